// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <string>

namespace facetloc::test {

/** \brief While it lives, C and C++ write numbers with a comma, as in a program of a graphical toolkit that
 * has set the user's locale. The German locale is compiled if the system lacks it but has its source. */
class DecimalComma {
public:
  DecimalComma()
      : before_(std::setlocale(LC_ALL, nullptr)), streams_before_(std::locale::global(withComma())) {
    constexpr const char* kGerman = "de_DE.UTF-8";
    set_ = std::setlocale(LC_ALL, kGerman) != nullptr;
    if (set_) return;
    folder_ = (std::filesystem::temp_directory_path() / "facetloc_locale_XXXXXX").string();
    if (!mkdtemp(folder_.data())) return;
    const std::string compile = "localedef -i de_DE -f UTF-8 " + folder_ + "/" + kGerman + " >/dev/null 2>&1";
    setenv("LOCPATH", folder_.c_str(), 1);
    set_ = std::system(compile.c_str()) == 0 && std::setlocale(LC_ALL, kGerman);
  }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;
  ~DecimalComma() {
    std::locale::global(streams_before_);
    std::setlocale(LC_ALL, before_.c_str());
    if (folder_.empty()) return;
    unsetenv("LOCPATH");
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  /** \brief False if only C++ streams write a comma. */
  bool isSetInC() const { return set_; }

private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  static std::locale withComma() { return std::locale(std::locale::classic(), new Comma); }

  std::string before_, folder_;
  std::locale streams_before_;
  bool set_ = false;
};

}  // namespace facetloc::test
