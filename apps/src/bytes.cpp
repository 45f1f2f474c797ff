// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/bytes.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/hypothesis.h>

#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace facetloc {
namespace {

void require(bool condition) {
  if (!condition) throw std::runtime_error("a message of another rank is torn");
}

// ---- What a value consists of, said once for both directions

template <class Archive>
void fields(Archive& archive, Intrinsics& k) {
  archive(k.width, k.height, k.fx, k.fy, k.cx, k.cy);
}

template <class Archive>
void fields(Archive& archive, ConvexHull& hull) {
  archive(hull.size);
  require(hull.size >= 0 && hull.size <= ConvexHull::kMaxVertices);
  for (int i = 0; i < hull.size; ++i) archive(hull.vertex[i]);
}

template <class Archive>
void fields(Archive& archive, Segment& s) {
  archive(s.R, s.t, s.Sigma_q, s.lambda, s.num_points, s.hull);
}

template <class Archive>
void fields(Archive& archive, DepthPicture& picture) {
  archive(picture.camera, picture.inverse_depth);
  if (Archive::kReads && !picture.empty())  // the rest is derived
    picture = DepthPicture::fromStored(picture.camera, std::move(picture.inverse_depth));
}

template <class Archive>
void fields(Archive& archive, View& view) {
  archive(view.camera, view.segments, view.depth);
}

template <class Archive>
void fields(Archive& archive, LocalModel& model) {
  archive(model.name, model.stamp, model.T_w_m, model.view);
}

template <class Archive>
void fields(Archive& archive, PackedModel& packed) {
  archive(packed.model, packed.depth);
}

template <class Archive>
void fields(Archive& archive, SegmentPair& pair) {
  archive(pair.scene, pair.model, pair.distance);
}

template <class Archive>
void fields(Archive& archive, Hypothesis& h) {
  archive(h.model, h.T_m_c.T, h.T_m_c.P, h.T_w_c, h.pairs, h.depth_assisted, h.consensus, h.free_space,
          h.evidence, h.score, h.probability);
}

template <class Archive>
void fields(Archive& archive, ResultRow& row) {
  archive(row.frame, row.rank, row.model, row.probability, row.score, row.T_m_c, row.T_w_c, row.sd_rot_deg,
          row.sd_trans_m, row.reason);
}

template <class Archive>
void fields(Archive& archive, FrameResult& result) {
  TimingRow& t = result.timing;
  archive(result.stamp, result.rows, t.frame, t.segment_ms, t.features_ms, t.localize_ms, t.models);
}

// ---- The two directions

class Writer {
public:
  static constexpr bool kReads = false;

  template <class... Values>
  void operator()(Values&... values) {
    (write(values), ...);
  }
  std::string take() { return std::move(bytes_); }

private:
  template <class T>
  void write(T& value) {
    if constexpr (std::is_arithmetic_v<T>)
      raw(&value, 1);
    else
      fields(*this, value);
  }
  template <class Scalar, int Rows, int Cols>
  void write(Eigen::Matrix<Scalar, Rows, Cols>& matrix) {
    raw(matrix.data(), matrix.size());
  }
  void write(Eigen::Isometry3d& T) { write(T.matrix()); }
  void write(std::string& text) {
    count(text.size());
    raw(text.data(), text.size());
  }
  template <class T>
  void write(std::optional<T>& value) {
    count(value.has_value());
    if (value) write(*value);
  }
  template <class T>
  void write(std::vector<T>& values) {
    count(values.size());
    if constexpr (std::is_arithmetic_v<T>)
      raw(values.data(), values.size());
    else
      for (T& value : values) write(value);
  }

  void count(std::size_t n) { raw(&n, 1); }
  template <class T>
  void raw(const T* values, std::size_t n) {
    bytes_.append(reinterpret_cast<const char*>(values), n * sizeof(T));
  }

  std::string bytes_;
};

class Reader {
public:
  static constexpr bool kReads = true;

  explicit Reader(const std::string& bytes) : at_(bytes.data()), left_(bytes.size()) {}

  template <class... Values>
  void operator()(Values&... values) {
    (read(values), ...);
  }
  bool atEnd() const { return left_ == 0; }

private:
  template <class T>
  void read(T& value) {
    if constexpr (std::is_arithmetic_v<T>)
      raw(&value, 1);
    else
      fields(*this, value);
  }
  template <class Scalar, int Rows, int Cols>
  void read(Eigen::Matrix<Scalar, Rows, Cols>& matrix) {
    raw(matrix.data(), matrix.size());
  }
  void read(Eigen::Isometry3d& T) { read(T.matrix()); }
  void read(std::string& text) {
    text.resize(count());
    raw(text.data(), text.size());
  }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    if (count() > 0) read(value.emplace());
  }
  template <class T>
  void read(std::vector<T>& values) {
    values.resize(count());
    if constexpr (std::is_arithmetic_v<T>)
      raw(values.data(), values.size());
    else
      for (T& value : values) read(value);
  }

  /** Of elements that follow, each of a byte or more. */
  std::size_t count() {
    std::size_t n = 0;
    raw(&n, 1);
    require(n <= left_);
    return n;
  }
  template <class T>
  void raw(T* values, std::size_t n) {
    require(n <= left_ / sizeof(T));
    if (n > 0) std::memcpy(values, at_, n * sizeof(T));
    at_ += n * sizeof(T);
    left_ -= n * sizeof(T);
  }

  const char* at_;
  std::size_t left_;
};

}  // namespace

template <class T>
std::string toBytes(const T& value) {
  Writer writer;
  writer(const_cast<T&>(value));  // a Writer changes nothing
  return writer.take();
}

template <class T>
T fromBytes(const std::string& bytes) {
  Reader reader(bytes);
  T value{};
  reader(value);
  require(reader.atEnd());
  return value;
}

#define FACETLOC_BYTES_OF(...)                                                                               \
  template std::string toBytes(const __VA_ARGS__&);                                                          \
  template __VA_ARGS__ fromBytes(const std::string&);
FACETLOC_BYTES_OF(std::size_t)
FACETLOC_BYTES_OF(std::vector<int>)
FACETLOC_BYTES_OF(std::vector<std::size_t>)
FACETLOC_BYTES_OF(std::vector<std::string>)
FACETLOC_BYTES_OF(std::optional<View>)
FACETLOC_BYTES_OF(std::vector<PackedModel>)
FACETLOC_BYTES_OF(std::vector<Hypothesis>)
FACETLOC_BYTES_OF(std::vector<FrameResult>)
#undef FACETLOC_BYTES_OF

}  // namespace facetloc
