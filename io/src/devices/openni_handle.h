// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <OpenNI.h>

#include <dlfcn.h>
#include <filesystem>
#include <string>

/** \file
 * The common part of our uses of OpenNI2, private to io. */

namespace facetloc {

/** \brief Where the loaded OpenNI2 library looks for drivers. */
inline std::string openniDriverFolder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&oniInitialize), &info) || !info.dli_fname) return "unknown";
  return (std::filesystem::path(info.dli_fname).parent_path() / "OpenNI2" / "Drivers").string();
}

/** \brief OpenNI2's message about the last error on this thread, in one line. */
inline std::string openniError() {
  std::string text = openni::OpenNI::getExtendedError();
  for (char& c : text)
    if (c == '\n' || c == '\t' || c == '\r') c = ' ';
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace facetloc
