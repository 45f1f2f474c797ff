// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tool_runner.h"

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace facetloc::test {

constexpr auto kPatience = std::chrono::seconds(120);  // on a busy machine; longer means that it hangs

/** \brief Waits until a condition holds. */
template <class Condition>
bool eventually(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    if (condition()) return true;
  return false;
}

/** \brief A command that runs beside the test, in a process group of its own, and is gone with the object. */
class Process {
public:
  /** \param command a path, its arguments */
  explicit Process(const std::vector<std::string>& command) {
    process_ = fork();
    if (process_ == 0) become(command);
    setpgid(process_, process_);  // whoever of the two is first
  }
  ~Process() {
    if (process_ <= 0) return;
    signal(SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t id() const { return process_; }
  /** \brief To it and all that it has started, as a terminal does. */
  void signal(int number) const { kill(-process_, number); }

  /** \brief Waits for its end. The code is 128 + n if signal n killed it, -1 if it hangs. */
  ToolRun wait() {
    int status = 0;
    if (!eventually([&] { return waitpid(process_, &status, WNOHANG) != 0; })) return {-1, out(), err()};
    process_ = -1;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return {code, out(), err()};
  }
  std::string out() const { return contentOf(folder_ / "out"); }
  std::string err() const { return contentOf(folder_ / "err"); }

private:
  [[noreturn]] void become(const std::vector<std::string>& command) const {
    setpgid(0, 0);
    const auto redirect = [&](const char* name, int stream) {
      dup2(open((folder_ / name).c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), stream);
    };
    redirect("out", STDOUT_FILENO);
    redirect("err", STDERR_FILENO);
    std::vector<std::string> copies = command;
    std::vector<char*> argv;
    for (std::string& argument : copies) argv.push_back(argument.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(127);
  }

  TemporaryFolder folder_;
  pid_t process_ = -1;
};

}  // namespace facetloc::test
