/// A user's hands on an X server: pointer, buttons, keys, density of the display.
#pragma once

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <chrono>
#include <string>
#include <thread>

namespace stbvh::harness {

class XClient {
 public:
  explicit XClient(const std::string& display) : display_(XOpenDisplay(display.c_str())) {}
  ~XClient() {
    if (display_ != nullptr) XCloseDisplay(display_);
  }
  XClient(const XClient&) = delete;
  XClient& operator=(const XClient&) = delete;

  /// What programs that start later take for the density of the screen.
  void set_dots_per_inch(int dots) {
    const std::string text = "Xft.dpi:\t" + std::to_string(dots) + "\n";
    XChangeProperty(display_, root(), XA_RESOURCE_MANAGER, XA_STRING, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
    XSync(display_, False);
  }

  /// Waits for a window of that title; false where none comes within a minute.
  bool find_window(const std::string& title) {
    for (int i = 0; i < 600; ++i) {
      Window parent, top, *children = nullptr;
      unsigned count = 0;
      XQueryTree(display_, root(), &top, &parent, &children, &count);
      for (unsigned c = 0; c < count; ++c) {
        char* name = nullptr;
        if (XFetchName(display_, children[c], &name) != 0 && name != nullptr) {
          if (title == name) window_ = children[c];
          XFree(name);
        }
      }
      if (children != nullptr) XFree(children);
      if (window_ != 0) return true;
      pause(100);
    }
    return false;
  }

  void move(int x, int y) {
    x_ = x;
    y_ = y;
    XWarpPointer(display_, None, window_, 0, 0, 0, 0, x, y);
    XSync(display_, False);
    pause(150);
  }
  /// 1: left, 3: right, 4 and 5: the wheel.
  void press(unsigned button) { send_button(ButtonPress, button); }
  void release(unsigned button) { send_button(ButtonRelease, button); }
  void key(KeySym symbol) {
    for (int type : {KeyPress, KeyRelease}) {
      XEvent event{};
      event.xkey.type = type;
      event.xkey.keycode = XKeysymToKeycode(display_, symbol);
      event.xkey.window = window_;
      event.xkey.root = root();
      event.xkey.time = CurrentTime;
      event.xkey.same_screen = True;
      XSendEvent(display_, window_, True, type == KeyPress ? KeyPressMask : KeyReleaseMask, &event);
      XSync(display_, False);
      pause(150);
    }
  }
  /// As a window manager asks a window to go.
  void ask_to_close() {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window_;
    event.xclient.message_type = XInternAtom(display_, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display_, "WM_DELETE_WINDOW", False));
    XSendEvent(display_, window_, False, NoEventMask, &event);
    XSync(display_, False);
  }
  static void pause(int milliseconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  }

 private:
  Window root() const { return DefaultRootWindow(display_); }
  void send_button(int type, unsigned button) {
    XEvent event{};
    event.xbutton.type = type;
    event.xbutton.button = button;
    event.xbutton.window = window_;
    event.xbutton.root = root();
    event.xbutton.time = CurrentTime;
    event.xbutton.x = x_;
    event.xbutton.y = y_;
    event.xbutton.same_screen = True;
    XSendEvent(display_, window_, True, type == ButtonPress ? ButtonPressMask : ButtonReleaseMask, &event);
    XSync(display_, False);
    pause(150);
  }

  Display* display_;
  Window window_ = 0;
  int x_ = 0, y_ = 0;
};

}  // namespace stbvh::harness
