// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <X11/Xlib.h>
#include <X11/keysym.h>
#include <memory>
#include <string>

namespace facetloc::test {

/** \brief Presses keys in a window of another process, on the display of DISPLAY. */
class Keyboard {
public:
  Keyboard() : display_(XOpenDisplay(nullptr)) {}

  /** \brief Presses a key in the first window whose name begins so. \return false without such a window. */
  bool press(KeySym key, const std::string& name) const {
    if (!display_) return false;
    const Window window = windowNamed(name, DefaultRootWindow(display_.get()));
    if (window == 0) return false;
    XKeyEvent event{};
    event.display = display_.get();
    event.window = window;
    event.root = DefaultRootWindow(display_.get());
    event.same_screen = True;
    event.keycode = XKeysymToKeycode(display_.get(), key);
    for (const int type : {KeyPress, KeyRelease}) {
      event.type = type;
      XSendEvent(display_.get(), window, True, type == KeyPress ? KeyPressMask : KeyReleaseMask,
                 reinterpret_cast<XEvent*>(&event));
    }
    XSync(display_.get(), False);
    return true;
  }

private:
  struct Close {
    void operator()(Display* display) const { XCloseDisplay(display); }
  };
  struct Free {
    template <typename T>
    void operator()(T* data) const {
      XFree(data);
    }
  };

  Window windowNamed(const std::string& name, Window parent) const {
    char* text = nullptr;
    if (XFetchName(display_.get(), parent, &text) != 0) {
      const std::unique_ptr<char, Free> owned(text);
      if (std::string(text).rfind(name, 0) == 0) return parent;
    }
    Window root = 0, above = 0, *list = nullptr;
    unsigned count = 0;
    if (XQueryTree(display_.get(), parent, &root, &above, &list, &count) == 0) return 0;
    const std::unique_ptr<Window, Free> children(list);
    for (unsigned i = 0; i < count; ++i)
      if (const Window found = windowNamed(name, list[i])) return found;
    return 0;
  }

  std::unique_ptr<Display, Close> display_;
};

}  // namespace facetloc::test

// Which Xlib.h takes from everybody.
#undef Bool
#undef None
#undef Status
#undef Success
