/// A window with OpenGL 3.3 and Dear ImGui in it: what no other file of the preview knows of.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/images/image.h"
#include "harness/program/usage_error.h"

struct GLFWwindow;

namespace stbvh::harness {

/// There is no window; what() is one sentence for the user.
struct WindowError : UsageError {
  using UsageError::UsageError;
};

/// A rectangle of the window, in its own coordinates.
struct WindowArea {
  float x = 0, y = 0, width = 0, height = 0;
};

class Window {
 public:
  /// `width` and `height` in the window system's units. Throws WindowError where there is no display, or none
  /// with OpenGL 3.3. One at a time.
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool is_closed() const;
  void close();
  void hide();
  void resize(int width, int height);
  void set_title(const std::string& title);
  void copy(const std::string& text);

  /// Pixels of the screen for each pixel that the user would call one: 2 on displays of double density.
  float scale() const { return scale_; }
  /// How many such pixels a part of the window has.
  struct PixelCount {
    std::size_t width, height;
  };
  PixelCount pixels_of(const WindowArea& area) const;

  /// Takes what the user has done, waiting for it, or for wake(), for at most `seconds`. True where there was
  /// anything.
  bool wait_for_input(double seconds);
  /// Ends wait_for_input(). From any thread, as long as there is the window.
  static void wake();
  /// Files that were dropped since the last call.
  std::vector<std::string> take_dropped();

  void begin_frame();
  /// Puts `image` where `area` is, behind everything else; `number` changes with the image.
  void show_image(const Image& image, std::uint64_t number, const WindowArea& area);
  /// Draws all; `before_swap` is called while the frame can be read.
  void end_frame(const std::function<void()>& before_swap);
  /// The frame as it is drawn: in `before_swap`.
  Image read_frame() const;

 private:
  void make_window(const std::string& title, int width, int height);
  void start_interface();

  GLFWwindow* window_ = nullptr;
  float scale_ = 1;
  unsigned texture_ = 0;
  std::uint64_t shown_number_ = 0;
  std::size_t texture_width_ = 0, texture_height_ = 0;
  bool has_input_ = false;
  std::vector<std::string> dropped_;
};

}  // namespace stbvh::harness
