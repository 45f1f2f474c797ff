// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "openni_driver_api.h"

#include <cstring>
#include <optional>

namespace facetloc {

/** \brief Hands a property out, if there is room for it. */
template <typename T>
OniStatus giveProperty(const T& value, void* data, int* size) {
  if (!data || *size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = static_cast<int>(sizeof value);
  return ONI_STATUS_OK;
}

/** \brief The value that a property is set to, if it is of the right size. */
template <typename T>
std::optional<T> takeProperty(const void* data, int size) {
  if (!data || size != static_cast<int>(sizeof(T))) return {};
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

}  // namespace facetloc
