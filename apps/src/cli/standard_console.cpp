// SPDX-License-Identifier: BSD-3-Clause
#include "cli/app.h"
#include "cli/text.h"

#include <pcl/console/print.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <ostream>
#include <streambuf>
#include <string>
#include <unistd.h>

namespace facetloc {
namespace {

/** Output to a reader that has gone away is dropped. */
bool writeAll(int stream, const char* text, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = ::write(stream, text + done, size - done);
    if (written < 0 && errno == EPIPE) return true;
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return true;
}

/** Standard output in printable characters. */
class PrintableOutput : public std::streambuf {
public:
  PrintableOutput() { setp(buffer_.data(), buffer_.data() + buffer_.size()); }
  ~PrintableOutput() override { write(); }

protected:
  int_type overflow(int_type c) override {
    if (!write()) return traits_type::eof();
    return traits_type::eq_int_type(c, traits_type::eof()) ? traits_type::not_eof(c)
                                                           : sputc(traits_type::to_char_type(c));
  }
  int sync() override { return write() ? 0 : -1; }

private:
  bool write() {
    const std::string text = printable({pbase(), static_cast<std::size_t>(pptr() - pbase())});
    setp(buffer_.data(), buffer_.data() + buffer_.size());
    return writeAll(STDOUT_FILENO, text.data(), text.size());
  }

  std::array<char, 1 << 16> buffer_;
};

/** Without this, the next file to be opened would take a closed stream's number, and receive its output. */
void openClosedStreams() {
  while (true) {
    const int number = open("/dev/null", O_RDWR);
    if (number > STDERR_FILENO) close(number);
    if (number < 0 || number > STDERR_FILENO) return;
  }
}

}  // namespace

Console standardConsole() {
  openClosedStreams();
  std::signal(SIGPIPE, SIG_IGN);
  // PCL's messages about a bad file come as an exception, once.
  if (!std::getenv("PCL_VERBOSITY_LEVEL")) pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  static PrintableOutput output;
  // A text that comes in one piece is written in one, from any thread.
  static Relay errors([](const char* text, std::streamsize size) {
    return writeAll(STDERR_FILENO, text, static_cast<std::size_t>(size));
  });
  static std::ostream out(&output), err(&errors);
  return {out, err, isatty(STDERR_FILENO) == 1, false, {}};
}

}  // namespace facetloc
