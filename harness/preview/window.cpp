#include "harness/preview/window.h"

#include <GL/gl.h>
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace stbvh::harness {
namespace {

constexpr float kFontSize = 13;  // of the font that ImGui brings, in pixels
constexpr int kLeastWidth = 64, kLeastHeight = 64;

std::string& last_error() {
  static std::string text;
  return text;
}

ImTextureID texture_id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture));
}

}  // namespace

Window::Window(const std::string& title, int width, int height) {
  glfwSetErrorCallback([](int, const char* text) { last_error() = text; });
#ifdef GLFW_PLATFORM  // GLFW 3.4: without a Wayland session its library prints a line of its own
  if (std::getenv("WAYLAND_DISPLAY") == nullptr) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
  if (glfwInit() != GLFW_TRUE)
    throw WindowError(fmt::format("There is no display to open a window on ({}).", last_error()));
  try {
    make_window(title, width, height);
  } catch (...) {
    glfwTerminate();
    throw;
  }
  start_interface();
}

void Window::make_window(const std::string& title, int width, int height) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr)
    throw WindowError(fmt::format("This display has no OpenGL 3.3 ({}).", last_error()));
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowSizeLimits(window_, kLeastWidth, kLeastHeight, GLFW_DONT_CARE, GLFW_DONT_CARE);
  float scale_y = 1;
  glfwGetWindowContentScale(window_, &scale_, &scale_y);
  scale_ = std::max(1.0f, scale_);
  glfwSetWindowUserPointer(window_, this);
  static constexpr auto touch = [](GLFWwindow* w) {
    static_cast<Window*>(glfwGetWindowUserPointer(w))->has_input_ = true;
  };
  // Set before ImGui's, which call them.
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double, double) { touch(w); });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int, int, int) { touch(w); });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double) { touch(w); });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int, int, int, int) { touch(w); });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned) { touch(w); });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* w, int, int) { touch(w); });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { touch(w); });
  glfwSetWindowCloseCallback(window_, [](GLFWwindow* w) { touch(w); });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    auto& window = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    window.dropped_.insert(window.dropped_.end(), paths, paths + count);
    touch(w);
  });
}

void Window::start_interface() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // leaves no file behind
  ImFontConfig font;
  font.SizePixels = std::round(kFontSize * scale_);
  io.Fonts->AddFontDefault(&font);
  ImGui::StyleColorsDark();
  ImGui::GetStyle().ScaleAllSizes(scale_);
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

Window::~Window() {
  glDeleteTextures(1, &texture_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::is_closed() const {
  return glfwWindowShouldClose(window_) != 0;
}

void Window::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::hide() {
  glfwHideWindow(window_);
}

void Window::resize(int width, int height) {
  glfwSetWindowSize(window_, width, height);
}

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

void Window::copy(const std::string& text) {
  glfwSetClipboardString(window_, text.c_str());
}

Window::PixelCount Window::pixels_of(const WindowArea& area) const {
  int width = 1, frame_width = 1, height = 1;
  glfwGetWindowSize(window_, &width, &height);
  glfwGetFramebufferSize(window_, &frame_width, &height);
  const float factor = static_cast<float>(frame_width) / static_cast<float>(std::max(width, 1)) / scale_;
  const auto count = [factor](float side) {
    return static_cast<std::size_t>(std::max(1.0f, std::round(side * factor)));
  };
  return {count(area.width), count(area.height)};
}

bool Window::wait_for_input(double seconds) {
  if (seconds > 0) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwPollEvents();
  }
  return std::exchange(has_input_, false);
}

void Window::wake() {
  glfwPostEmptyEvent();
}

std::vector<std::string> Window::take_dropped() {
  return std::exchange(dropped_, {});
}

void Window::begin_frame() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void Window::show_image(const Image& image, std::uint64_t number, const WindowArea& area) {
  if (image.rgb.empty()) return;
  if (number != shown_number_) {
    const auto width = static_cast<GLsizei>(image.width), height = static_cast<GLsizei>(image.height);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (image.width != texture_width_ || image.height != texture_height_) {
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, width, height, 0, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
      texture_width_ = image.width;
      texture_height_ = image.height;
    } else {
      glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
    }
    shown_number_ = number;
  }
  ImGui::GetBackgroundDrawList()->AddImage(texture_id(texture_), {area.x, area.y},
                                           {area.x + area.width, area.y + area.height});
}

void Window::end_frame(const std::function<void()>& before_swap) {
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  glViewport(0, 0, width, height);
  glClearColor(0.1f, 0.1f, 0.1f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  before_swap();
  glfwSwapBuffers(window_);
}

Image Window::read_frame() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  Image image{static_cast<std::size_t>(width), static_cast<std::size_t>(height), {}};
  const std::size_t row = 3 * image.width;
  std::vector<std::uint8_t> upwards(row * image.height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, upwards.data());
  image.rgb.resize(upwards.size());
  for (std::size_t y = 0; y < image.height; ++y)
    std::copy_n(&upwards[(image.height - 1 - y) * row], row, &image.rgb[y * row]);
  return image;
}

}  // namespace stbvh::harness
