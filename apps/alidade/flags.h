// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "alidade/core/aliases.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"

// The flags and arguments of a command, and checks of their values. No command includes the parser's own
// header, because it takes seconds to compile.

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace alidade {

/// Headings of flags that several commands share. A command with few flags of its own leaves them under
/// "Options".
inline constexpr const char* kBoardGroup = "Boards and images";
inline constexpr const char* kFootageGroup = "Footage";
inline constexpr const char* kCameraFileGroup = "Reading camera files";
inline constexpr const char* kFitGroup = "Fit";
inline constexpr const char* kVerdictGroup = "Accuracy";
inline constexpr const char* kOutputGroup = "Output";
inline constexpr const char* kCommonGroup = "All commands";

/// Checks of a value: the error in the text; empty if it is valid. The parser's own checks print their limits
/// as numbers, and that of a double has 300 digits. All refuse values that are not finite: every comparison
/// with NaN is false, so that a limit of NaN would have no effect.
[[nodiscard]] std::string finiteNumber(const std::string& text);
[[nodiscard]] std::string positiveNumber(const std::string& text);
[[nodiscard]] std::string nonNegativeNumber(const std::string& text);
/// A positive number of pixels, see parsePixels().
[[nodiscard]] std::string pixelComplaint(const std::string& text);
/// WIDTHxHEIGHT, see parseSize().
[[nodiscard]] std::string sizeComplaint(const std::string& text);
/// A whole number from `least` to `most`.
[[nodiscard]] std::string wholeComplaint(const std::string& text, int least, int most);

/// "600x400" or "10,20,600,400" as this many whole numbers; nothing for other text.
[[nodiscard]] std::optional<std::vector<int>> wholeNumbers(std::string_view text, char separator,
                                                           std::size_t count);
/// "640x480", sides of 1 to a million; nothing for other text.
[[nodiscard]] std::optional<ImageSize> parseSize(std::string_view text);
/// A positive number of pixels: "0.1px", "0.1 px" or "0.1"; nothing for other text.
[[nodiscard]] std::optional<double> parsePixels(std::string_view text);

/// Numbers with or without a unit, in pixels and metres; NaN for other text.
[[nodiscard]] double pixelsOrNan(const std::string& text);
[[nodiscard]] double metresOrNan(const std::string& text);

/// The allowed values of a flag.
struct Values {
  const char* word = nullptr;  ///< placeholder in the help, by which shells complete files or folders
  std::string (*complaint)(const std::string& text) = nullptr;  ///< error in a value; empty: none
  const char* limits = "";                                      ///< of a value, shown in the help
  std::vector<std::string> choices = {};
  std::vector<AliasedName> aliases = {};                ///< words of other programs for choices
  double (*number)(const std::string& text) = nullptr;  ///< converts text that may have a unit
  char separator = 0;                                   ///< between values in one word; 0: none
  bool is_single = false;                               ///< each use of the flag takes one value
  bool is_aside = false;  ///< affects the presentation of a result and not its content; see settings()
};

inline const Values kFilePath = {.word = "FILE"};
inline const Values kFolder = {.word = "FOLDER"};
inline const Values kSpec = {.word = "SPEC"};  ///< of a board; may also be a file
inline const Values kPixelText = {.complaint = pixelComplaint};
inline const Values kSizeText = {.complaint = sizeComplaint};
inline const Values kAside = {.is_aside = true};
[[nodiscard]] Values aside(Values values);
[[nodiscard]] Values oneOf(std::vector<std::string> choices, char separator = 0,
                           std::vector<AliasedName> aliases = {});

/// The options of every command.
struct CommonOptions {
  std::string command;  ///< see Flags::command()
  bool json = false;
  bool quiet = false;
  int jobs = 0;
  std::string config;
  std::string junit;                   ///< of commands that have the flag; see junit.h
  const CancelFlag* cancel = nullptr;  ///< of commands that can be interrupted
};

/// The flags and arguments of one command.
class Flags {
 public:
  /// Destination of a value. Defaults other than "" and 0 appear in the help.
  using Variable = std::variant<std::string*, std::vector<std::string>*, double*, int*, std::size_t*,
                                std::optional<double>*, std::optional<int>*, std::optional<ImageSize>*>;

  explicit Flags(CLI::App& parser) : parser_(&parser) {}

  /// Adds examples, notes and exit codes after the flags.
  void explain(const std::string& text);
  /// Sets the heading of the following flags.
  void under(const char* heading) { heading_ = heading; }
  /// A flag ("-o,--output") or an argument ("input") with a value.
  void add(const std::string& names, Variable variable, const std::string& text, const Values& values = {});
  void addSwitch(const std::string& names, bool& variable, const std::string& text, bool is_aside = false);
  /// Flags of other programs, or of another command, which this one lacks: they are refused with the words to
  /// type instead. Not in the help.
  void redirect(const std::vector<std::string>& names, const std::string& next_step);
  /// The refusal of the first of these words that is such a flag; empty: none is.
  [[nodiscard]] std::string redirection(std::span<const char* const> words) const;
  /// The flags --json, --quiet, --config, and --jobs if a command has parallel work.
  void addCommon(CommonOptions& options, bool has_jobs);

  [[nodiscard]] bool isGiven(const std::string& name) const;
  /// The command as typed after the program's name: "rig calibrate".
  [[nodiscard]] std::string command() const;
  [[nodiscard]] const CLI::App& parser() const { return *parser_; }

  /// The rotation of an image by 0, 90, 180 or 270 degrees.
  void addQuarterTurns(const std::string& names, std::optional<int>& degrees, const std::string& text) {
    add(names, &degrees, text, oneOf({"0", "90", "180", "270"}));
  }

  /// Sets flags that are not on the command line to the values in a settings file.
  /// @throws Error (kInput) for a key that is not a flag of the command, or an invalid value
  void applySettingsFile(const std::string& path);
  /// The effective flags and values in order of name, without arguments and flags with `is_aside`.
  using Setting = std::pair<std::string, std::vector<std::string>>;
  [[nodiscard]] std::vector<Setting> settings() const;

 private:
  void place(CLI::Option* option, bool is_aside);

  CLI::App* parser_;
  const char* heading_ = nullptr;
  std::set<const CLI::Option*> aside_;
  std::vector<std::pair<std::string, std::string>> redirects_;  // a flag and the words to type instead
};

/// The words that select a parser: "alidade rig calibrate"; and the same without the program's name.
[[nodiscard]] std::string callOf(const CLI::App& app);
[[nodiscard]] std::string commandName(const CLI::App& command);

}  // namespace alidade
