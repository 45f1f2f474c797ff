// SPDX-License-Identifier: BSD-3-Clause
#include "base/message_passing.h"

#include <algorithm>
#include <cstdint>
// The C interface is all we use; the old C++ one would ask for a library of its own.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#include <stdexcept>

namespace facetloc::mpi {
namespace {

constexpr std::uint64_t kPiece = 1u << 30;  // [B] MPI counts are int

/** Calls transfer(pointer, n) for piece after piece. */
template <class Transfer>
void inPieces(std::string& bytes, const Transfer& transfer) {
  for (std::uint64_t first = 0; first < bytes.size(); first += kPiece)
    transfer(bytes.data() + first, static_cast<int>(std::min<std::uint64_t>(kPiece, bytes.size() - first)));
}

}  // namespace

Place join() {
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  if (provided < MPI_THREAD_FUNNELED) throw std::runtime_error("this MPI knows no threads");
  Place place{};
  MPI_Comm_rank(MPI_COMM_WORLD, &place.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &place.size);
  MPI_Comm here;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, place.rank, MPI_INFO_NULL, &here);
  MPI_Comm_size(here, &place.ranks_here);
  MPI_Comm_free(&here);
  return place;
}

void leave() { MPI_Finalize(); }

void abort(int code) { MPI_Abort(MPI_COMM_WORLD, code); }

void broadcast(std::string& bytes) {
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
  bytes.resize(size);
  inPieces(bytes, [](char* piece, int n) { MPI_Bcast(piece, n, MPI_CHAR, 0, MPI_COMM_WORLD); });
}

void send(std::string bytes, int to) {
  std::uint64_t size = bytes.size();
  MPI_Send(&size, 1, MPI_UINT64_T, to, 0, MPI_COMM_WORLD);
  inPieces(bytes, [to](char* piece, int n) { MPI_Send(piece, n, MPI_CHAR, to, 0, MPI_COMM_WORLD); });
}

std::string receive(int from) {
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  inPieces(bytes, [from](char* piece, int n) {
    MPI_Recv(piece, n, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  });
  return bytes;
}

}  // namespace facetloc::mpi
