// SPDX-License-Identifier: BSD-3-Clause
#include "cli/heartbeat.h"

#include <chrono>
#include <condition_variable>
#include <fmt/format.h>
#include <mutex>
#include <ostream>
#include <streambuf>
#include <thread>

namespace facetloc {

/** The thread that speaks when nothing is printed. */
class Heartbeat::Watch {
public:
  Watch(const Console& console, std::string what) : console_(console), what_(std::move(what)) {
    if (!console_.quiet) thread_ = std::thread([this] { watch(); });
  }
  ~Watch() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ended_ = true;
    }
    end_.notify_one();
    if (thread_.joinable()) thread_.join();
    clear();
  }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /** Writes text for the work. \return false if the stream fails. */
  bool write(std::ostream& stream, const char* text, std::streamsize size) {
    const std::lock_guard<std::mutex> lock(mutex_);
    clear();
    stream.write(text, size).flush();
    spoke_ = Clock::now();
    return static_cast<bool>(stream);
  }

private:
  using Clock = std::chrono::steady_clock;

  void watch() {
    const auto silence = console_.terminal ? std::chrono::seconds(1) : std::chrono::seconds(2);
    std::unique_lock<std::mutex> lock(mutex_);
    while (!end_.wait_until(lock, spoke_ + silence, [this] { return ended_; })) {
      if (Clock::now() < spoke_ + silence) continue;
      if (console_.terminal)
        console_.show(fmt::format("{}: {:.0f} s", what_, seconds()));
      else
        console_.err << "." << std::flush;
      spoke_ = Clock::now();
      beating_ = true;
    }
  }

  /** Ends the line of dots, so that the next output begins on an empty line. */
  void clear() {
    if (!beating_) return;
    if (console_.terminal)
      console_.show("");
    else
      console_.err << "\n";
    beating_ = false;
  }

  const Console& console_;
  const std::string what_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point spoke_ = start_;
  bool beating_ = false;  // a line of ours is not ended
  bool ended_ = false;
  std::mutex mutex_;
  std::condition_variable end_;
  std::thread thread_;
};

/** Hands text of the work to a stream of the console. */
class Heartbeat::Relay : public std::streambuf {
public:
  Relay(Watch& watch, std::ostream& stream) : watch_(watch), stream_(stream) {}

protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char text = traits_type::to_char_type(c);
    return xsputn(&text, 1) == 1 ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    return watch_.write(stream_, text, size) ? size : 0;
  }

private:
  Watch& watch_;
  std::ostream& stream_;
};

Heartbeat::Heartbeat(const Console& console, const std::string& what)
    : console_(console),
      watch_(std::make_unique<Watch>(console, what)),
      out_relay_(std::make_unique<Relay>(*watch_, console.out)),
      err_relay_(std::make_unique<Relay>(*watch_, console.err)),
      out_(std::make_unique<std::ostream>(out_relay_.get())),
      err_(std::make_unique<std::ostream>(err_relay_.get())) {}

Heartbeat::~Heartbeat() = default;

Console Heartbeat::console(std::ostream& out) const {
  return {out,           *err_, console_.terminal, console_.quiet,
          console_.tool, true,  console_.findings, console_.publish};
}

Console Heartbeat::console() const { return console(*out_); }

double Heartbeat::seconds() const { return watch_->seconds(); }

}  // namespace facetloc
