// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <facetloc/io/map_database.h>

#include <filesystem>

namespace facetloc::map_connection {

inline constexpr const char* kFormatKey = "format";  ///< meta rows that belong to the file format
inline constexpr const char* kConventionsKey = "conventions";

/** \brief A new database with empty tables. \param shown its name in errors */
sqlite::Connection create(const std::filesystem::path& path, const std::filesystem::path& shown);
sqlite::Connection openForWriting(const std::filesystem::path& path);
/** \brief Read-only. Only where a killed writer has left half a transaction, that is rolled back first. */
sqlite::Connection openForReading(const std::filesystem::path& path);

std::filesystem::path journalOf(const std::filesystem::path& path);
/** \brief A journal that outlives its database would be rolled back into the next one of that name. */
void removeWithJournal(const std::filesystem::path& path);

}  // namespace facetloc::map_connection
