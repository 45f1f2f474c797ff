// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "recordings/message_file.h"

#include <algorithm>
#include <bzlib.h>
#include <cstring>
#include <fmt/format.h>
#include <lz4frame.h>
#include <memory>
#include <zstd.h>

namespace facetloc::internal {
namespace {

constexpr std::size_t kPart = 1 << 18;  // bytes that are unpacked at a time

/** Calls step(out, room, in, left) -> {written, read, going on} until it is done, fails or has made `most`
 * bytes. \return was the end of the last frame reached? */
template <typename Step>
bool unpack(ByteView packed, std::uint64_t most, Bytes& out, const Step& step) {
  std::size_t at = 0;
  bool whole = packed.size == 0;
  while (true) {
    const std::size_t size = out.size(), room = std::min<std::uint64_t>(kPart, most + 1 - size);
    out.resize(size + room);
    const auto [written, read, state] = step(out.data() + size, room, packed.data + at, packed.size - at);
    out.resize(size + written);
    at += read;
    whole = state == 0;
    const bool stuck = written == 0 && read == 0;
    if (state < 0 || out.size() > most || stuck || (whole && at == packed.size)) break;
  }
  if (out.size() > most) out.resize(most), whole = false;
  return whole && at == packed.size;
}

struct Progress {
  std::size_t written, read;
  int state;  // 0: at the end of a frame; negative: failed
};

bool zstd(ByteView packed, std::uint64_t most, Bytes& out) {
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                             ZSTD_freeDStream);
  if (!stream) throw std::bad_alloc();
  constexpr int kLargestWindow = 27;  // log2 of bytes, as the zstd program allows unless told otherwise
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, kLargestWindow);
  return unpack(packed, most, out,
                [&stream](std::uint8_t* to, std::size_t room, const std::uint8_t* from, std::size_t left) {
                  ZSTD_outBuffer output{to, room, 0};
                  ZSTD_inBuffer input{from, left, 0};
                  const std::size_t state = ZSTD_decompressStream(stream.get(), &output, &input);
                  return Progress{output.pos, input.pos, ZSTD_isError(state) ? -1 : state == 0 ? 0 : 1};
                });
}

bool lz4(ByteView packed, std::uint64_t most, Bytes& out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(raw,
                                                                             LZ4F_freeDecompressionContext);
  return unpack(packed, most, out,
                [&context](std::uint8_t* to, std::size_t room, const std::uint8_t* from, std::size_t left) {
                  std::size_t written = room, read = left;
                  const std::size_t state =
                      LZ4F_decompress(context.get(), to, &written, from, &read, nullptr);
                  if (LZ4F_isError(state)) return Progress{0, 0, -1};
                  return Progress{written, read, state == 0 ? 0 : 1};
                });
}

bool bz2(ByteView packed, std::uint64_t most, Bytes& out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> end(&stream, BZ2_bzDecompressEnd);
  return unpack(
      packed, most, out,
      [&stream](std::uint8_t* to, std::size_t room, const std::uint8_t* from, std::size_t left) {
        stream.next_out = reinterpret_cast<char*>(to);
        stream.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(from));
        stream.avail_out = static_cast<unsigned>(room);
        stream.avail_in = static_cast<unsigned>(left);
        const int state = BZ2_bzDecompress(&stream);
        if (state != BZ_OK && state != BZ_STREAM_END) return Progress{0, 0, -1};
        return Progress{room - stream.avail_out, left - stream.avail_in, state == BZ_STREAM_END ? 0 : 1};
      });
}

}  // namespace

bool isZstd(ByteView packed) {
  constexpr std::uint8_t kMagic[] = {0x28, 0xB5, 0x2F, 0xFD};
  return packed.size >= sizeof kMagic && std::memcmp(packed.data, kMagic, sizeof kMagic) == 0;
}

Bytes unpackZstd(ByteView packed, std::uint64_t most, const std::string& name) {
  Bytes out;
  if (!zstd(packed, most, out)) throw IoError(name, "has a message whose Zstandard frame is corrupt or torn");
  return out;
}

Bytes unpackedChunk(ByteView packed, const std::string& compression, std::uint64_t most,
                    const std::string& name) {
  Bytes out;
  if (compression.empty())
    out.assign(packed.data, packed.data + std::min<std::uint64_t>(packed.size, most));
  else if (compression == "zstd")
    zstd(packed, most, out);
  else if (compression == "lz4")
    lz4(packed, most, out);
  else if (compression == "bz2")
    bz2(packed, most, out);
  else
    throw IoError(name, fmt::format("has chunks that are compressed by {}, not by lz4, zstd or bz2",
                                    text::quoted(compression)));
  return out;
}

}  // namespace facetloc::internal
