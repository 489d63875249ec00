#include "formats/chunk_unpack.hpp"

#include <bzlib.h>
#include <lz4.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "formats/lz4_salvage.hpp"
#include "loopstone/base/memory_budget.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kFirstRoom = std::size_t{1} << 22;
/// A file that says more of itself has to prove it by what comes out.
constexpr std::uint64_t kBelievedGrowth = 64;
constexpr std::size_t kStep = std::size_t{1} << 20;

constexpr const char* kDamaged = "what is packed in this chunk is damaged";
constexpr const char* kCut = "this chunk ends too early";

std::string too_much(std::uint64_t most_bytes) {
  return "this chunk unpacks to more than " + bytes_text(most_bytes);
}

bool starts_lz4_frame(std::string_view stored) {
  return stored.starts_with(std::string_view("\x04\x22\x4d\x18", 4));
}

}  // namespace

std::optional<Packing> packing_of(std::string_view word) {
  if (word.empty() || word == "none") return Packing::kNone;
  if (word == "bz2") return Packing::kBzip2;
  if (word == "lz4") return Packing::kLz4;
  if (word == "zstd") return Packing::kZstd;
  return std::nullopt;
}

struct ChunkUnpacker::Job {
  std::string_view stored;
  std::uint64_t stated_size;
  std::uint64_t most_bytes;
  const std::function<void()>& stop;

  /// Room to begin with.
  [[nodiscard]] std::size_t first_room() const {
    const std::uint64_t believed =
        std::max<std::uint64_t>(kFirstRoom, saturated_product(stored.size(), kBelievedGrowth));
    return static_cast<std::size_t>(
        std::min({std::max<std::uint64_t>(stated_size, 1), believed, most_bytes}));
  }
};

struct ChunkUnpacker::Contexts {
  LZ4F_dctx* lz4 = nullptr;
  ZSTD_DCtx* zstd = nullptr;

  ~Contexts() {
    if (lz4 != nullptr) LZ4F_freeDecompressionContext(lz4);
    if (zstd != nullptr) ZSTD_freeDCtx(zstd);
  }
};

ChunkUnpacker::ChunkUnpacker() : contexts_(std::make_unique<Contexts>()) {}
ChunkUnpacker::~ChunkUnpacker() = default;

UnpackedChunk ChunkUnpacker::unpack(Packing packing, std::string_view stored,
                                    std::uint64_t stated_size, std::uint64_t most_bytes,
                                    const std::function<void()>& stop) {
  if (stored.empty() && stated_size == 0) return {};
  const Job job{stored, stated_size, most_bytes, stop};
  switch (packing) {
    case Packing::kBzip2:
      return unpack_bzip2(job);
    case Packing::kLz4:
      return starts_lz4_frame(stored) ? unpack_lz4(job) : unpack_lz4_block(job);
    case Packing::kZstd:
      return unpack_zstd(job);
    default:
      return {stored, stored.size(), {}};
  }
}

/// False when there may be no more.
bool ChunkUnpacker::make_room(std::size_t used, const Job& job) {
  if (used < buffer_.size() && used < job.most_bytes) return true;
  if (used >= job.most_bytes) return false;
  (void)buffer_.grown(used + kStep, used);
  return true;
}

UnpackedChunk ChunkUnpacker::unpack_bzip2(const Job& job) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return {{}, 0, "no memory to unpack it"};
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> ended(&stream, BZ2_bzDecompressEnd);
  (void)buffer_.at_least(job.first_room());
  UnpackedChunk chunk;
  std::size_t used = 0;
  constexpr std::size_t kMostInput = std::size_t{1} << 30;
  while (true) {
    if (!make_room(used, job)) {
      chunk.damage = too_much(job.most_bytes);
      break;
    }
    job.stop();
    const std::size_t room =
        std::min({buffer_.size() - used, kStep, static_cast<std::size_t>(job.most_bytes) - used});
    const std::size_t input = std::min(job.stored.size() - chunk.consumed, kMostInput);
    stream.next_in = const_cast<char*>(job.stored.data() + chunk.consumed);
    stream.avail_in = static_cast<unsigned>(input);
    stream.next_out = buffer_.data() + used;
    stream.avail_out = static_cast<unsigned>(room);
    const int status = BZ2_bzDecompress(&stream);
    chunk.consumed += input - stream.avail_in;
    const std::size_t made = room - stream.avail_out;
    used += made;
    if (status == BZ_STREAM_END) break;
    if (status != BZ_OK) chunk.damage = kDamaged;
    if (status == BZ_OK && made == 0 && stream.avail_in == 0) chunk.damage = kCut;
    if (!chunk.damage.empty()) break;
  }
  chunk.bytes = {buffer_.data(), used};
  return chunk;
}

UnpackedChunk ChunkUnpacker::unpack_lz4(const Job& job) {
  if (contexts_->lz4 == nullptr &&
      LZ4F_isError(LZ4F_createDecompressionContext(&contexts_->lz4, LZ4F_VERSION)) != 0) {
    return {{}, 0, "no memory to unpack it"};
  }
  LZ4F_resetDecompressionContext(contexts_->lz4);
  (void)buffer_.at_least(job.first_room());
  UnpackedChunk chunk;
  std::size_t used = 0;
  while (true) {
    job.stop();
    std::size_t made = std::min(buffer_.size(), static_cast<std::size_t>(job.most_bytes)) - used;
    std::size_t read = job.stored.size() - chunk.consumed;
    // What lies behind `used` may move when the buffer grows: then the output is not stable.
    const LZ4F_decompressOptions_t how{};
    const std::size_t status = LZ4F_decompress(contexts_->lz4, buffer_.data() + used, &made,
                                               job.stored.data() + chunk.consumed, &read, &how);
    if (LZ4F_isError(status) != 0) {
      used = salvage_lz4(job);
      chunk.damage = kDamaged;
      break;
    }
    used += made;
    chunk.consumed += read;
    if (status == 0) {
      if (!starts_lz4_frame(job.stored.substr(chunk.consumed))) break;
    } else if (made == 0 && read == 0 && used < buffer_.size() && used < job.most_bytes) {
      used = std::max(used, salvage_lz4(job));
      chunk.damage = kCut;
      break;
    }
    if (!make_room(used, job)) {
      chunk.damage = too_much(job.most_bytes);
      break;
    }
  }
  chunk.bytes = {buffer_.data(), used};
  return chunk;
}

std::size_t ChunkUnpacker::salvage_lz4(const Job& job) {
  std::size_t used = 0;
  do {
    job.stop();
    const std::size_t room = std::min(buffer_.size(), static_cast<std::size_t>(job.most_bytes));
    used = salvage_lz4_frame(job.stored, buffer_.data(), room);
  } while (used == buffer_.size() && make_room(used, job));
  return used;
}

UnpackedChunk ChunkUnpacker::unpack_lz4_block(const Job& job) {
  // A byte makes at most 255; how many it makes, a bare block does not say.
  const std::uint64_t possible = saturated_product(job.stored.size(), 255);
  const auto room = static_cast<std::size_t>(
      std::min({job.stated_size, possible, job.most_bytes,
                static_cast<std::uint64_t>(std::numeric_limits<int>::max())}));
  char* const out = buffer_.at_least(room + 1);
  const auto stored =
      static_cast<int>(std::min<std::size_t>(job.stored.size(), std::numeric_limits<int>::max()));
  const int made = LZ4_decompress_safe(job.stored.data(), out, stored, static_cast<int>(room));
  if (made >= 0) return {{out, static_cast<std::size_t>(made)}, job.stored.size(), {}};
  const SalvagedBlock salvaged = salvage_lz4_block(job.stored, out, 0, room);
  return {{out, salvaged.used}, job.stored.size(), kDamaged};
}

UnpackedChunk ChunkUnpacker::unpack_zstd(const Job& job) {
  if (contexts_->zstd == nullptr) contexts_->zstd = ZSTD_createDCtx();
  if (contexts_->zstd == nullptr) return {{}, 0, "no memory to unpack it"};
  job.stop();
  const std::size_t room = job.first_room();
  char* const out = buffer_.at_least(room);
  const std::size_t made =
      ZSTD_decompressDCtx(contexts_->zstd, out, room, job.stored.data(), job.stored.size());
  if (ZSTD_isError(made) == 0) return {{out, made}, job.stored.size(), {}};
  return salvage_zstd(job);
}

/// Block by block, which also tells where a frame ends that has something else behind it.
UnpackedChunk ChunkUnpacker::salvage_zstd(const Job& job) {
  constexpr std::size_t kInput = 256;  // an error takes with it what the same call has made
  ZSTD_DCtx* const context = contexts_->zstd;
  ZSTD_DCtx_reset(context, ZSTD_reset_session_only);
  UnpackedChunk chunk;
  ZSTD_outBuffer out{buffer_.data(), 0, 0};
  while (true) {
    if (out.pos >= job.most_bytes) {
      chunk.damage = too_much(job.most_bytes);
      break;
    }
    job.stop();
    // Always as much room, since it decides on what an error takes with it.
    out.dst = buffer_.grown(out.pos + kStep, out.pos);
    out.size = std::min(out.pos + kStep, static_cast<std::size_t>(job.most_bytes));
    const std::size_t before = out.pos;
    const std::string_view left = job.stored.substr(chunk.consumed);
    ZSTD_inBuffer in{left.data(), std::min(left.size(), kInput), 0};
    const std::size_t status = ZSTD_decompressStream(context, &out, &in);
    if (ZSTD_isError(status) != 0) {
      chunk.damage = kDamaged;
      break;
    }
    chunk.consumed += in.pos;
    const bool has_more = left.substr(in.pos).starts_with(std::string_view("\x28\xb5\x2f\xfd", 4));
    if (status == 0 && !has_more) break;
    if (in.pos == 0 && out.pos == before && out.pos < out.size) {
      chunk.damage = kCut;
      break;
    }
  }
  chunk.bytes = {buffer_.data(), out.pos};
  return chunk;
}

}  // namespace loopstone
