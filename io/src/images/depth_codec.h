// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief The depth of an .oni frame from its bytes: 16-bit numbers as differences to the one before.
 *
 * A byte below E0 holds two differences, 6 - high and 6 - low nibble. A low nibble of F says that a longer
 * one follows, D that there is no second. E0 + n stands for 2n times the same number again, FF for a longer
 * difference: one byte from 80 on, 192 less the difference, or else two, high byte first, that are the number
 * itself.
 *
 * \param with_table the numbers are indices of a table, which stands in front: its size and its entries.
 * \param size how many numbers there are.
 * \return nothing if the bytes are not the code of that number of values. */
std::vector<std::uint16_t> decodeDepth(const std::vector<std::uint8_t>& bytes, bool with_table,
                                       std::size_t size);

}  // namespace facetloc
