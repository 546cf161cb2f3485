/// The user interface: what can be set and read of a model.
#pragma once

#include <string>

#include "harness/preview/frame_times.h"
#include "harness/preview/preview_model.h"
#include "harness/preview/window.h"

namespace stbvh::harness {

/// What the panels keep between frames.
struct PanelState {
  bool is_shown = true;
  std::string save_path = "preview";
  bool drags_split = false;
};

/// The part of a window of this size that the picture has: all but the panels, where there is room for both.
WindowArea picture_area(const PanelState& panels, float width, float height, float scale);

/// Draws the panels, and takes what the mouse and keys do to the picture in `area`.
void draw_panels(PreviewModel& model, PanelState& panels, const FrameTimes& times, const WindowArea& area,
                 Window& window);

/// What the mouse and keys do to the picture in `area`.
void handle_picture_input(PreviewModel& model, PanelState& panels, const WindowArea& area, Window& window);

/// The line between A and B.
void draw_split_line(const PreviewModel& model, const WindowArea& area, float scale);

/// The window of the time line of a subtree.
void draw_time_line(PreviewModel& model, const WindowArea& area, float scale);

}  // namespace stbvh::harness
