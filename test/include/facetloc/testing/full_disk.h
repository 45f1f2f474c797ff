// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <sys/resource.h>

namespace facetloc::test {

/** For as long as it lives, no file grows beyond a size: writes fail as they do on a full disk, but in the
 * words for a file that is too large. */
class FullDisk {
public:
  explicit FullDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

  static constexpr const char* kWords = "cannot be written: File too large";

private:
  rlimit before_ = {};
  void (*handler_)(int) = nullptr;
};

}  // namespace facetloc::test
