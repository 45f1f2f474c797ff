// SPDX-License-Identifier: BSD-3-Clause
#include "tool_runner.h"

#include <facetloc/features/params.h>

namespace facetloc::test {
namespace {

struct ExampleParams {
  double angular_threshold = 2.5;
  int max_pairs = 6;
  bool faithful = false;
  bool robust = true;

  static constexpr const char* kTitle = "Matching of examples";
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("angular_threshold", p.angular_threshold, -90.0, 90.0, "Largest angle [deg].");
    visit("max_pairs", p.max_pairs, 1, 16, "Limit of pairs.");
    visit("faithful", p.faithful, false, true, "As the paper.");
    visit("robust", p.robust, false, true, "Trimmed.");
  }
};

enum class Way { shortest, scenic };
constexpr const char* kNamesOfWays[] = {"shortest", "scenic"};
constexpr const auto& namesOf(Way) { return kNamesOfWays; }

struct WayParams {
  static constexpr const char* kTitle = "Ways";
  Way method = Way::shortest;
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("method", p.method, Way::shortest, Way::scenic, "Which way.");
  }
};

/** Prints the way that it was given. */
class WayApp : public App {
public:
  WayApp() : App("facetloc_echo", "", "") {}

private:
  void addOptions(CommandLine& line) override { line.addParams(params_, "way"); }
  int execute(const CommandLine&, const Console& console) override {
    console.out << numberText(params_.method);
    return kOk;
  }
  WayParams params_;
};

struct ShownParams {
  static constexpr const char* kTitle = "What users need";
  double size = 1;
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("size", p.size, 0.0, 2.0, "Size [m].");
  }
};

/** Prints its options. */
class EchoApp : public App {
public:
  EchoApp() : App("facetloc_echo", "INPUT... -o DIR", "Repeats its options.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("INPUT", inputs_);
    line.addOption("output,o", output_, "DIR", "Folder.");
    line.addOption("max-hypotheses", max_hypotheses_, "K", "Limit.");
    line.addSwitch("labels", labels_, "Labels.");
    line.addParams(params_, "matching");
    line.addParams(shown_, "shown", CommandLine::Shown::in_help);
    line.addPresets();
  }
  int execute(const CommandLine& line, const Console& console) override {
    console.out << inputs_.size() << " " << output_ << " " << max_hypotheses_ << " " << labels_ << " "
                << params_.angular_threshold << " " << params_.max_pairs << " " << params_.faithful << " "
                << params_.robust << " " << threads() << " " << console.quiet << " "
                << line.given("matching.angular_threshold");
    return kOk;
  }

  std::vector<std::string> inputs_;
  std::string output_;
  int max_hypotheses_ = 100;
  bool labels_ = false;
  ExampleParams params_;
  ShownParams shown_;
};

ToolRun echo(const std::vector<std::string>& arguments) { return runTool<EchoApp>(arguments); }

void expectUsageError(const ToolRun& run, const std::string& cause) {
  EXPECT_EQ(run.code, kUsage);
  EXPECT_THAT(run.err, HasAll("facetloc_echo: ", cause, "--help"));
  EXPECT_THAT(run.out, IsEmpty());
}

TEST(CommandLine, DefaultsComeFromTheVariables) { EXPECT_EQ(echo({"a"}).out, "1  100 0 2.5 6 0 1 0 0 0"); }

TEST(CommandLine, GnuAndPclStyleAreTheSame) {
  const std::string told = "2 dir 7 1 -30 3 0 1 4 1 1";
  EXPECT_EQ(
      echo({"a", "b", "-o", "dir", "--max-hypotheses", "7", "--labels", "--matching.angular_threshold=-30",
            "--matching.max-pairs", "3", "--threads", "4", "--quiet"})
          .out,
      told);
  EXPECT_EQ(echo({"-output", "dir", "-max_hypotheses=7", "a", "-labels", "-matching.angular-threshold", "-30",
                  "-matching.max_pairs", "3", "b", "-threads=4", "-q"})
                .out,
            told);
}

TEST(CommandLine, TruthValuesMayStandAlone) {
  EXPECT_EQ(echo({"--matching.faithful", "a"}).out, "1  100 0 2.5 6 1 1 0 0 0");
  EXPECT_EQ(echo({"-matching.faithful", "1", "-matching.robust", "0", "a"}).out, "1  100 0 2.5 6 1 0 0 0 0");
  EXPECT_EQ(echo({"--matching.faithful=false", "--matching.robust=no", "a"}).out, "1  100 0 2.5 6 0 0 0 0 0");
}

TEST(CommandLine, MisspeltOptionsAreRefused) {
  expectUsageError(echo({"a", "--angular_treshold", "2"}),
                   "unrecognised option '--angular_treshold'; did you mean '--");
  expectUsageError(echo({"a", "-angular_treshold", "2"}), "unrecognised option '-angular_treshold'");
  expectUsageError(echo({"a", "--angular", "2"}), "unrecognised option '--angular'");  // no guessing
  expectUsageError(echo({"a", "-oops"}), "unrecognised option '-oops'");               // is not -o oops
  expectUsageError(echo({"--INPUT=a"}), "unrecognised option '--INPUT'");
}

TEST(CommandLine, AChoiceGoesByName) {
  EXPECT_EQ(runTool<WayApp>({}).out, "shortest");
  EXPECT_EQ(runTool<WayApp>({"--way.method", "scenic"}).out, "scenic");
  EXPECT_EQ(runTool<WayApp>({"--way.method=shortest"}).out, "shortest");
  EXPECT_EQ(runTool<WayApp>({"--way", "scenic"}).out, "scenic");  // for short
  TemporaryFolder folder;
  const std::string file = folder / "way.ini";
  std::ofstream(file) << "[way]\nmethod = scenic\n";
  EXPECT_EQ(runTool<WayApp>({"--params", file}).out, "scenic");
  EXPECT_THAT(runTool<WayApp>({"--help-all"}).out, HasSubstr("shortest"));
  for (const char* way : {"shortcut", "Scenic", "0", "1"})
    expectUsageError(runTool<WayApp>({"--way", way}),
                     "way.method: '" + std::string(way) + "' is none of: shortest, scenic");
  expectUsageError(runTool<WayApp>({"--way"}), "value of option '--way' is missing");
}

TEST(CommandLine, OptionsOverridePresets) {
  expectUsageError(echo({"a", "--preset", "unheard_of"}), "unknown preset 'unheard_of'; there are: paper");
  EXPECT_EQ(echo({"a", "--preset", "paper"}).out,
            "1  1000 0 2.5 6 0 1 0 0 0");  // parameters that it lacks are left out
  EXPECT_EQ(echo({"a", "--preset", "paper", "--max-hypotheses", "7"}).out, "1  7 0 2.5 6 0 1 0 0 0");
}

TEST(CommandLine, ValuesMayBeginWithAMinus) {
  expectUsageError(runTool<WayApp>({"--way", "-0.48,0.36"}), "'-0.48,0.36' is none of");
  expectUsageError(runTool<WayApp>({"--way", "-x,0.36"}), "value of option '--way' is missing");
}

TEST(CommandLine, BadValuesAreRefused) {
  expectUsageError(echo({"a", "--matching.max_pairs", "abc"}), "'abc'");
  expectUsageError(echo({"a", "--matching.max_pairs", "2.5"}), "'2.5'");
  expectUsageError(echo({"a", "--matching.angular_threshold"}),
                   "value of option '--matching.angular_threshold' is missing");
  expectUsageError(echo({"a", "-o", "--labels"}), "value of option '-o' is missing");
  expectUsageError(echo({"--output=", "a"}), "value of option '--output' is empty");
  expectUsageError(echo({"a", "--matching.max_pairs=1", "--matching.max_pairs=2"}), "more than once");
  expectUsageError(echo({"a", "--threads", "-1"}), "threads");
  expectUsageError(echo({"a", "--labels=1"}), "labels");
  expectUsageError(echo({"a", "--matching.faithful=maybe"}), "'maybe'");
}

TEST(CommandLine, APlaceholderOfBoostIsRefused) {  // its message would never end
  expectUsageError(echo({"a", "--max-hypotheses=%value%"}), "%value%' cannot be an argument");
}

TEST(CommandLine, ValuesOutOfRangeNameTheParameter) {
  expectUsageError(echo({"a", "--matching.max_pairs", "17"}),
                   "parameter matching.max_pairs = 17 is outside [1, 16]");
  expectUsageError(echo({"a", "--matching.angular_threshold", "nan"}),
                   "parameter matching.angular_threshold");
}

TEST(CommandLine, ArgumentsAreRequired) { expectUsageError(echo({}), "INPUT is missing"); }

TEST(CommandLine, HelpAndVersion) {
  const ToolRun help = ok(echo({"--help"}));
  EXPECT_THAT(help.out, HasAll("Usage: facetloc_echo INPUT... -o DIR", "Repeats its options.",
                               "--max-hypotheses K (=100)", "What users need:", "--shown.size NUMBER (=1)",
                               "--params", "--help-all", Not(HasSubstr("angular_threshold"))));
  const ToolRun all = echo({"--help-all"});
  const std::size_t same = help.out.find("Options of all tools:");
  EXPECT_EQ(all.out.substr(0, same), help.out.substr(0, same));  // and more
  EXPECT_THAT(all.out.substr(same),
              HasAll("-h [ --help ]", "--params FILE", "Matching of examples:",
                     "--matching.angular_threshold NUMBER (=2.5)", "Largest angle [deg]."));
  EXPECT_THAT(echo({"--version"}).out, testing::MatchesRegex("facetloc [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

class ParamsFile : public InAFolder {
protected:
  ToolRun echoWith(const std::string& content, std::vector<std::string> arguments = {"a"}) {
    writeContent(path_, content);
    arguments.insert(arguments.end(), {"--params", path_});
    return echo(arguments);
  }
  const std::string path_ = folder_ / "params.ini";
};

TEST_F(ParamsFile, IsReadAndTheCommandLineWins) {
  const std::string content =
      "# ours\nlabels = true\n[matching]\nmax_pairs = 9   # few\n\nangular-threshold=1.5\nfaithful = 1\n";
  EXPECT_EQ(echoWith(content).out, "1  100 1 1.5 9 1 1 0 0 1");
  EXPECT_EQ(echoWith(content, {"a", "-matching.max_pairs", "2", "--matching.faithful=0"}).out,
            "1  100 1 1.5 2 0 1 0 0 1");
}

TEST_F(ParamsFile, MayHaveAByteOrderMarkAndOtherEndsOfLines) {
  for (const char* content : {"\xEF\xBB\xBFmatching.max_pairs = 9\n", "# ours\rmatching.max_pairs = 9\r",
                              "# ours\r\nmatching.max_pairs = 9\r\n"})
    EXPECT_EQ(echoWith(content).out, "1  100 0 2.5 9 0 1 0 0 0");
}

TEST_F(ParamsFile, ReadsTheOutputOfToIni) {
  ExampleParams params;
  params.angular_threshold = 1.0 / 4;
  params.robust = false;
  EXPECT_EQ(echoWith(toIni(params, "matching")).out, "1  100 0 0.25 6 0 0 0 0 1");
}

TEST_F(ParamsFile, FaultsAreUsageErrors) {
  expectUsageError(echoWith("[matching]\nmax_pears = 9\n"), "line 2: unknown parameter 'matching.max_pears'");
  expectUsageError(echoWith("\nmax_pairs 9\n"), "line 2: expected name = value");
  expectUsageError(echoWith("matching.max_pairs =\n"), "line 1: matching.max_pairs has no value");
  expectUsageError(echoWith("matching.max_pairs = nine\n"), "'nine'");
  expectUsageError(echoWith("[ matching ]\nmax_pairs = 99\n"), "parameter matching.max_pairs = 99");
  expectUsageError(echoWith("help = 1\n"), "unknown parameter 'help'");
  expectUsageError(echo({"a", "--params", folder_ / "nowhere.ini"}), "nowhere.ini: cannot be read");
  expectUsageError(echo({"a", "--params", folder_ / "."}), "cannot be read");
}

TEST(App, HelpThatCannotBeWrittenIsAFailure) {
  for (const char* option : {"--help", "--version"}) {
    std::ostringstream full, err;
    full.setstate(std::ios::badbit);
    EXPECT_EQ(EchoApp().run({option}, Console{full, err, false, false, {}}), kFailed);
    EXPECT_THAT(err.str(), HasSubstr("the output cannot be written"));
  }
}

/** Fails in the way it is asked to. */
class FailingApp : public App {
public:
  FailingApp() : App("facetloc_fail", "", "Fails.") {}

private:
  void addOptions(CommandLine&) override {}
  int execute(const CommandLine&, const Console&) override {
    throw std::runtime_error("map.flmap: no such file");
  }
};

TEST(App, ExceptionsBecomeAMessageAndAnExitCode) {
  const ToolRun run = runTool<FailingApp>({});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_EQ(run.err, "facetloc_fail: map.flmap: no such file\n");
}

}  // namespace
}  // namespace facetloc::test
