// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress.h"

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <fmt/core.h>
#include <thread>

namespace facetloc {
namespace {

constexpr auto kRefresh = std::chrono::milliseconds(100);

std::string duration(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s < 120) return fmt::format("{} s", s);
  if (s < 7200) return fmt::format("{} min", (s + 30) / 60);
  return fmt::format("{:.1f} h", static_cast<double>(s) / 3600);
}

std::atomic<bool> g_raised{false};  // StopSignal's flag, which all threads look at
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
int g_objects = 0;  // StopSignals that live

/** Handles either signal once: the next one, of whichever kind, has its usual effect. */
void raiseFlag(int) {
  g_raised = true;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

std::string progressLine(std::size_t done, std::size_t total, double seconds) {
  const std::string all = std::to_string(total);
  std::string line = fmt::format("{:>{}}/{}", done, all.size(), all);
  if (done == 0 || !(seconds > 0)) return line;
  const double rate = static_cast<double>(done) / seconds;
  line += fmt::format("  {:.1f}/s", rate);
  if (done < total) line += fmt::format("  {} left", duration(static_cast<double>(total - done) / rate));
  return line;
}

Progress::Progress(const Console& console, std::size_t total)
    : console_(console), visible_(console.terminal && !console.quiet && total > 1), total_(total) {}

Progress::~Progress() { clear(); }

void Progress::clear() {
  if (visible_) console_.show("");
  visible_ = false;
}

void Progress::step() {
  if (!visible_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  const Clock::time_point now = Clock::now();
  if (done_ < total_ && now - shown_ < kRefresh) return;
  shown_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  console_.show(progressLine(done_, total_, seconds));
  if (done_ == total_) clear();  // the next output begins on an empty line
}

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
  /** Writes texts of the work to a stream of the console. */
  Relay relayTo(std::ostream& stream) {
    return Relay([this, &stream](const char* text, std::streamsize size) {
      const std::lock_guard<std::mutex> lock(mutex_);
      clear();
      stream.write(text, size).flush();
      spoke_ = Clock::now();
      return static_cast<bool>(stream);
    });
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

Heartbeat::Heartbeat(const Console& console, const std::string& what)
    : console_(console),
      watch_(std::make_unique<Watch>(console, what)),
      out_relay_(watch_->relayTo(console.out)),
      err_relay_(watch_->relayTo(console.err)) {}

Heartbeat::~Heartbeat() = default;

Console Heartbeat::console(std::ostream& out) const {
  return {out,           err_, console_.terminal, console_.quiet,
          console_.tool, true, console_.findings, console_.publish};
}

Console Heartbeat::console() const { return console(out_); }

double Heartbeat::seconds() const { return watch_->seconds(); }

StopSignal::StopSignal() {
  if (g_objects++ == 0) g_raised = false;
  struct sigaction action = {};
  action.sa_handler = raiseFlag;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &interrupt_before_);
  sigaction(SIGTERM, &action, &terminate_before_);
}

StopSignal::~StopSignal() {
  --g_objects;
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
}

bool StopSignal::raised() const { return g_raised; }

}  // namespace facetloc
