// SPDX-License-Identifier: BSD-3-Clause
#include "batch/message_passing.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
// The C interface is all we use; the old C++ one would ask for a library of its own.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#include <stdexcept>
#include <thread>
#include <vector>

namespace facetloc::mpi {
namespace {

constexpr std::uint64_t kPiece = 1u << 30;  // [B] MPI counts are int
constexpr auto kNap = std::chrono::milliseconds(1);
constexpr std::size_t kMostOnTheirWay = 16;

/** A message that is being sent, which stays where it is until then. */
struct Sent {
  std::uint64_t size;
  std::string bytes;
  std::vector<MPI_Request> requests;

  bool isDone() {
    int done = 0;
    MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
    return done != 0;
  }
};
std::deque<Sent> g_sent;

/** Calls transfer(pointer, n) for piece after piece. */
template <class Transfer>
void inPieces(std::string& bytes, const Transfer& transfer) {
  for (std::uint64_t first = 0; first < bytes.size(); first += kPiece)
    transfer(bytes.data() + first, static_cast<int>(std::min<std::uint64_t>(kPiece, bytes.size() - first)));
}

/** Waits until no more than that are on their way. */
void waitForSent(std::size_t most) {
  while (!g_sent.empty()) {
    if (g_sent.front().isDone())
      g_sent.pop_front();
    else if (g_sent.size() > most)
      std::this_thread::sleep_for(kNap);
    else
      return;
  }
}

ProcessId join() {
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  if (provided < MPI_THREAD_FUNNELED) throw std::runtime_error("this MPI library does not support threads");
  ProcessId place{};
  MPI_Comm_rank(MPI_COMM_WORLD, &place.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &place.size);
  MPI_Comm here;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, place.rank, MPI_INFO_NULL, &here);
  MPI_Comm_size(here, &place.ranks_here);
  MPI_Comm_free(&here);
  return place;
}

void send(const std::string& bytes, int to) {
  waitForSent(kMostOnTheirWay);
  Sent& sent = g_sent.emplace_back(Sent{bytes.size(), bytes, {}});
  MPI_Isend(&sent.size, 1, MPI_UINT64_T, to, 0, MPI_COMM_WORLD, &sent.requests.emplace_back());
  inPieces(sent.bytes, [&](char* piece, int n) {
    MPI_Isend(piece, n, MPI_CHAR, to, 0, MPI_COMM_WORLD, &sent.requests.emplace_back());
  });
}

std::optional<std::string> receive(int from, const std::function<bool()>& givesUp) {
  for (int there = 0;; std::this_thread::sleep_for(kNap)) {
    MPI_Iprobe(from, 0, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) break;
    if (givesUp()) return {};
  }
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  inPieces(bytes, [from](char* piece, int n) {
    MPI_Recv(piece, n, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  });
  return bytes;
}

}  // namespace

extern "C" const Calls* facetlocMessagePassing() {
  static const Calls calls{join, [] { MPI_Finalize(); }, [](int code) { MPI_Abort(MPI_COMM_WORLD, code); },
                           send, [] { waitForSent(0); }, receive};
  return &calls;
}

}  // namespace facetloc::mpi
