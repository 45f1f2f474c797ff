// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace facetloc {

/** \brief - and _ are the same in names. */
std::string underscored(std::string name);

/** \brief The known word that was probably meant, written as it is known; empty if none is near: a third of
 * the characters may be wrong. Of a word in groups, such as ekf.iterations, the last part alone may be meant.
 * The first one of several that are equally near. */
std::string nearestWord(const std::string& word, const std::vector<std::string>& known);

/** \brief "; did you mean '--map'?", or nothing. \param prefix of the word as it is shown */
std::string didYouMean(const std::string& word, const std::vector<std::string>& known,
                       const std::string& prefix = "");

}  // namespace facetloc
