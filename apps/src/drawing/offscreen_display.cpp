// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/offscreen_display.h"

#include <X11/Xlib.h>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace facetloc {
namespace {

constexpr int kPatience = 10000;  // [ms] for Xvfb to come up

/** Runs in the child: becomes Xvfb, which writes the number of its display to a pipe. */
[[noreturn]] void becomeServer(int pipe_end, const char* pipe_name) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // it does not outlive us, however we end
  setsid();                          // a Ctrl-C that ends the tool cleanly does not kill it
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  fcntl(pipe_end, F_SETFD, 0);
  execlp("Xvfb", "Xvfb", "-displayfd", pipe_name, "-screen", "0", "1280x1024x24", "-nolisten", "tcp",
         "-noreset", static_cast<char*>(nullptr));
  _exit(127);
}

/** The display's number up to the end of the line: Xvfb dies of a pipe that is closed before. */
std::string readDisplayNumber(int pipe_end) {
  std::string number;
  for (;;) {
    pollfd wait{pipe_end, POLLIN, 0};
    char c = 0;
    if (poll(&wait, 1, kPatience) != 1 || read(pipe_end, &c, 1) != 1) return {};
    if (c == '\n') return number;
    number += c;
  }
}

}  // namespace

bool displayUsable() {
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name) return false;
  Display* display = XOpenDisplay(nullptr);
  if (display) XCloseDisplay(display);
  return display != nullptr;
}

OffscreenDisplay::OffscreenDisplay() {
  if (displayUsable()) return;
  if (const char* before = std::getenv("DISPLAY")) display_before_ = before;
  startServer();
}

void OffscreenDisplay::startServer() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    problem_ = "no pipe to start Xvfb with";
    return;
  }
  const std::string pipe_name = std::to_string(ends[1]);
  server_ = fork();
  if (server_ == 0) becomeServer(ends[1], pipe_name.c_str());
  close(ends[1]);
  const std::string number = server_ > 0 ? readDisplayNumber(ends[0]) : "";
  close(ends[0]);
  if (!number.empty()) {
    setenv("DISPLAY", (":" + number).c_str(), 1);
    return;
  }
  stopServer();
  problem_ = "no X server can be reached (DISPLAY), and Xvfb cannot be started; install the package xvfb";
}

void OffscreenDisplay::stopServer() {
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
  server_ = -1;
}

OffscreenDisplay::~OffscreenDisplay() {
  if (server_ <= 0) return;
  stopServer();
  if (display_before_)
    setenv("DISPLAY", display_before_->c_str(), 1);
  else
    unsetenv("DISPLAY");
}

}  // namespace facetloc
