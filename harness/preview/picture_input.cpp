#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "harness/preview/panels.h"

namespace stbvh::harness {
namespace {

constexpr float kSplitReach = 6;         // pixels of the user on either side of the line
constexpr double kDegreesForEach = 0.4;  // pixel of the user that the mouse goes
constexpr double kDollyForEach = 0.9;    // step of the wheel

#if IMGUI_VERSION_NUM >= 18700

bool pressed(ImGuiKey key) {
  return ImGui::IsKeyPressed(key, false);
}

bool pressed(char key) {
  if (key >= 'A' && key <= 'Z') return pressed(static_cast<ImGuiKey>(ImGuiKey_A + (key - 'A')));
  if (key >= '0' && key <= '9') return pressed(static_cast<ImGuiKey>(ImGuiKey_0 + (key - '0')));
  return pressed(key == ' ' ? ImGuiKey_Space : key == ',' ? ImGuiKey_Comma : ImGuiKey_Period);
}

#else  // keys are numbers of the window system's: of GLFW, letters in upper case

bool pressed(ImGuiKey_ key) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), false);
}

bool pressed(char key) {
  return ImGui::IsKeyPressed(key, false);
}

#endif

void handle_view_keys(PreviewModel& model) {
  ViewOptions& view = model.view_options;
  for (char key = '1'; key <= '4'; ++key) {
    if (pressed(key)) view.mode = static_cast<ViewMode>(key - '1');
  }
  if (pressed('H')) view.heat = static_cast<HeatMap>((static_cast<int>(view.heat) + 1) % 3);
  if (pressed('T')) model.tree_options.shows_boxes = !model.tree_options.shows_boxes;
  if (pressed('L')) model.tree_options.shows_time_line = !model.tree_options.shows_time_line;
  std::size_t& level = model.tree_options.level;
  if (pressed(',')) level = level > 0 ? level - 1 : 0;
  if (pressed('.')) ++level;
}

void handle_keys(PreviewModel& model, PanelState& panels, Window& window) {
  handle_view_keys(model);
  Animation& animation = model.animation;
  if (pressed(' ')) animation.is_playing = !animation.is_playing;
  if (pressed('F')) animation.is_frozen = !animation.is_frozen;
  if (pressed('S')) model.save(panels.save_path);
  if (pressed('C')) window.copy(model.command_line());
  if (pressed(ImGuiKey_Escape)) model.cancel();
  if (pressed(ImGuiKey_Tab)) panels.is_shown = !panels.is_shown;
}

bool shows_split(const PreviewModel& model) {
  return model.view_options.mode == ViewMode::kSplit && model.state().picture &&
         model.state().picture->slots == kSlots;
}

/// Whether the mouse has the line between A and B.
bool handle_split(PreviewModel& model, PanelState& panels, const WindowArea& area, float scale) {
  ViewOptions& view = model.view_options;
  if (!shows_split(model)) return false;
  const ImGuiIO& io = ImGui::GetIO();
  const float x = area.x + static_cast<float>(view.split) * area.width;
  const bool is_near = std::abs(io.MousePos.x - x) < kSplitReach * scale && !io.WantCaptureMouse;
  if (is_near && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) panels.drags_split = true;
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) panels.drags_split = false;
  if (panels.drags_split)
    view.split = std::clamp(static_cast<double>((io.MousePos.x - area.x) / area.width), 0.0, 1.0);
  if (is_near || panels.drags_split) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  return panels.drags_split;
}

}  // namespace

void draw_split_line(const PreviewModel& model, const WindowArea& area, float scale) {
  if (!shows_split(model)) return;
  const float x = area.x + static_cast<float>(std::clamp(model.view_options.split, 0.0, 1.0)) * area.width;
  ImGui::GetBackgroundDrawList()->AddLine({x, area.y}, {x, area.y + area.height},
                                          IM_COL32(255, 255, 255, 200), scale);
}

void handle_picture_input(PreviewModel& model, PanelState& panels, const WindowArea& area, Window& window) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!io.WantTextInput) handle_keys(model, panels, window);
  if (handle_split(model, panels, area, window.scale()) || io.WantCaptureMouse) return;
  if (!ImGui::IsMousePosValid()) return;
  const double dx = static_cast<double>(io.MouseDelta.x / window.scale());
  const double dy = static_cast<double>(io.MouseDelta.y / window.scale());
  const bool left = ImGui::IsMouseDragging(ImGuiMouseButton_Left);
  if (ImGui::IsMouseDragging(ImGuiMouseButton_Middle) || (left && io.KeyShift)) {
    const double height = static_cast<double>(area.height / window.scale());
    model.camera.pan(-dx / height, dy / height);
  } else if (left) {
    model.camera.orbit(-kDegreesForEach * dx, kDegreesForEach * dy);
  } else if (ImGui::IsMouseDragging(ImGuiMouseButton_Right)) {
    model.camera.dolly(std::exp(0.01 * dy));
  }
  if (io.MouseWheel != 0) model.camera.dolly(std::pow(kDollyForEach, static_cast<double>(io.MouseWheel)));
  const double x = static_cast<double>((io.MousePos.x - area.x) / area.width);
  const double y = static_cast<double>((io.MousePos.y - area.y) / area.height);
  const bool is_inside = x >= 0 && x < 1 && y >= 0 && y < 1;
  const bool is_click = ImGui::IsMouseReleased(ImGuiMouseButton_Left) &&
                        ImGui::GetMouseDragDelta(ImGuiMouseButton_Left).x == 0 &&
                        ImGui::GetMouseDragDelta(ImGuiMouseButton_Left).y == 0;
  if (!is_click || !is_inside) return;
  if (io.KeyCtrl) {
    model.pick_subtree(x, y);
  } else {
    model.focus(x, y);
  }
}

}  // namespace stbvh::harness
