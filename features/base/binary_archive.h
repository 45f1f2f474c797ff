// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <istream>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

/** \file
 * Values as bytes, every number to the last bit and in the machine's own order. The content of a type
 * is listed once for both directions, by a function in its namespace like the one for Intrinsics. */

namespace facetloc::internal {

template <class Archive>
void fields(Archive& archive, Intrinsics& k) {
  archive(k.width, k.height, k.fx, k.fy, k.cx, k.cy);
}

class BinaryWriter {
public:
  static constexpr bool kReads = false;

  explicit BinaryWriter(std::ostream& out) : out_(out) {}

  template <class... Values>
  void operator()(const Values&... values) {
    (write(const_cast<Values&>(values)), ...);  // fields() has one form for both; this one changes nothing
  }

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
    raw(matrix.data(), static_cast<std::size_t>(matrix.size()));
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
    out_.write(reinterpret_cast<const char*>(values), static_cast<std::streamsize>(n * sizeof(T)));
  }

  std::ostream& out_;
};

/** \brief Throws std::runtime_error where the bytes end too early; exceptions of the stream pass. */
class BinaryReader {
public:
  static constexpr bool kReads = true;

  explicit BinaryReader(std::istream& in) : in_(in) {}

  template <class... Values>
  void operator()(Values&... values) {
    (read(values), ...);
  }

private:
  template <class T>
  void read(T& value) {
    if constexpr (std::is_same_v<T, bool>)
      value = truth();
    else if constexpr (std::is_arithmetic_v<T>)
      raw(&value, 1);
    else
      fields(*this, value);
  }
  template <class Scalar, int Rows, int Cols>
  void read(Eigen::Matrix<Scalar, Rows, Cols>& matrix) {
    raw(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  void read(Eigen::Isometry3d& T) { read(T.matrix()); }
  void read(std::string& text) { readAll(text); }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    const std::size_t n = count();
    if (n > 1) throw std::runtime_error("some bytes are wrong");
    if (n == 1) read(value.emplace());
  }
  template <class T>
  void read(std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      readAll(values);
    } else {
      values.clear();
      for (std::size_t n = count(); n > 0; --n) read(values.emplace_back());
      values.shrink_to_fit();
    }
  }

  std::size_t count() {
    std::size_t n = 0;
    raw(&n, 1);
    return n;
  }
  /** A bool of any other byte than these two would be neither true nor false. */
  bool truth() {
    unsigned char byte = 0;
    raw(&byte, 1);
    if (byte > 1) throw std::runtime_error("some bytes are wrong");
    return byte == 1;
  }
  /** Bytes that are none of ours may claim any number of elements: memory is taken as they come. */
  template <class Values>
  void readAll(Values& values) {
    constexpr std::size_t kAtOnce = 1 << 16;
    values.clear();
    for (std::size_t left = count(); left > 0;) {
      const std::size_t n = std::min(left, kAtOnce), old = values.size();
      values.resize(old + n);
      raw(values.data() + old, n);
      left -= n;
    }
    values.shrink_to_fit();
  }
  template <class T>
  void raw(T* values, std::size_t n) {
    const auto size = static_cast<std::streamsize>(n * sizeof(T));
    in_.read(reinterpret_cast<char*>(values), size);
    if (in_.gcount() != size) throw std::runtime_error("some bytes are missing");
  }

  std::istream& in_;
};

}  // namespace facetloc::internal
