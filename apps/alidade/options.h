// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/start/options.h"
#include "alidade/files/camera_source.h"

// A command of the program, flags that several commands have, and checks of what was given.

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace alidade {

inline constexpr double kDegPerRad = 180 / std::numbers::pi;

/// What every command can be told.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int jobs = 0;
  std::string config;
};

/// One command of the program: its flags, and what it does with them.
class Command {
 public:
  virtual ~Command() = default;
  /// Adds flags and help to the command's own parser.
  virtual void setUp(CLI::App& app) = 0;
  /// Does the work. @returns the exit code
  virtual int run(const CLI::App& app) = 0;
  /// Whether standard output is still to get its JSON document, so that an error has to be one.
  [[nodiscard]] virtual bool owesJson() const { return common_.json; }

 protected:
  CommonOptions common_;
};

/// Names of values, for CLI::Option::type_name(). They appear in the help, and shells complete files or
/// folders by them; a SPEC of a board may be a file too.
inline constexpr const char* kFileValue = "FILE";
inline constexpr const char* kFolderValue = "FOLDER";
inline constexpr const char* kSpecValue = "SPEC";
inline constexpr const char* kCommandValue = "COMMAND";

/// Headings of the flags that several commands have, for CLI::Option::group(). A command with few flags of
/// its own leaves them under "Options".
inline constexpr const char* kBoardGroup = "Boards and images";
inline constexpr const char* kFootageGroup = "Footage";
inline constexpr const char* kCameraFileGroup = "Incomplete camera files";
inline constexpr const char* kFitGroup = "Fit";
inline constexpr const char* kVerdictGroup = "Accuracy";
inline constexpr const char* kOutputGroup = "Output";
inline constexpr const char* kCommonGroup = "All commands";

[[nodiscard]] std::unique_ptr<Command> makeDetectCommand();
[[nodiscard]] std::unique_ptr<Command> makeCalibrateCommand();
[[nodiscard]] std::unique_ptr<Command> makeProjectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUnprojectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUndistortCommand();
[[nodiscard]] std::unique_ptr<Command> makeValidateCommand();
[[nodiscard]] std::unique_ptr<Command> makeDiffCommand();
[[nodiscard]] std::unique_ptr<Command> makeFleetCommand();
[[nodiscard]] std::unique_ptr<Command> makeConvertCommand();
[[nodiscard]] std::unique_ptr<Command> makeSimulateCommand();
[[nodiscard]] std::unique_ptr<Command> makeReportCommand();
[[nodiscard]] std::unique_ptr<Command> makeBoardCommand();
[[nodiscard]] std::unique_ptr<Command> makeTrackCommand();
[[nodiscard]] std::unique_ptr<Command> makeHelpCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigCalibrateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigValidateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigTriangulateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigRectifyCommand();

/// The exit code where the work is done and the answer is no.
inline constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);

/// The flags --json, --quiet, --config, and --jobs where a command has work to share out.
void addCommonOptions(CLI::App& app, CommonOptions& options, bool has_jobs);

/// The flag --board, which may be repeated. A SPEC that is wrong is refused where it was given, on the
/// command line or in a settings file.
void addBoardOption(CLI::App& app, std::vector<std::string>& boards);

/// How a command reads images and videos to find boards in them.
struct DetectionOptions {
  std::size_t num_frames = 100;  ///< to search, of each video or sequence
  std::string cache;             ///< folder; empty: none
};

/// The flags --frames and --cache.
void addDetectionOptions(CLI::App& app, DetectionOptions& options);

/// The flag --debug, for commands that find boards.
void addDebugOption(CLI::App& app, std::string& folder);

/// What a user can add to a camera file of another tool that leaves things open.
struct CameraOptions {
  std::string size;     ///< "640x480"; empty = the file says
  std::string read_as;  ///< model; empty = the file says

  [[nodiscard]] ReadOptions readOptions() const;
};

/// The flags --image-size and --read-as.
void addCameraOptions(CLI::App& app, CameraOptions& options);

/// The one camera of a file of any format. What was passed over or assumed in reading it is told, unless
/// `quiet`.
[[nodiscard]] CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet);

/// The same of a file that was read.
[[nodiscard]] CameraRecord onlyCameraTelling(const CameraSource& source, bool quiet);

/// Checks of a flag's number, for CLI::Option::check(): what is wrong with the text, or nothing. The parser's
/// own name their limits as numbers, and that of a double has 300 digits. All refuse what is not finite:
/// every comparison with NaN is false, so that a limit of NaN would switch off what it limits.
[[nodiscard]] std::string finiteNumber(const std::string& text);
[[nodiscard]] std::string positiveNumber(const std::string& text);
[[nodiscard]] std::string nonNegativeNumber(const std::string& text);

/// "600x400" or "10,20,600,400" as so many whole numbers; nothing for anything else.
[[nodiscard]] std::optional<std::vector<int>> wholeNumbers(std::string_view text, char separator,
                                                           std::size_t count);

/// "640x480", sides of 1 to a million; nothing for anything else.
[[nodiscard]] std::optional<ImageSize> parseSize(std::string_view text);
/// The check of a flag for it.
[[nodiscard]] std::string sizeComplaint(const std::string& text);

/// A positive number of pixels: "0.1px", "0.1 px" or "0.1"; nothing for anything else.
[[nodiscard]] std::optional<double> parsePixels(std::string_view text);
/// The check of a flag for it.
/// Of "flat", "warp", "uneven" or "auto".
[[nodiscard]] BoardShapeMode shapeMode(std::string_view name);
[[nodiscard]] std::string pixelComplaint(const std::string& text);

/// Lets the number of a flag that is checked as such be written with its unit: pixels (0.5px), or a length in
/// metres (2m, 30cm).
void takePixels(CLI::Option& option);
void takeLength(CLI::Option& option);

/// What the user types for a parser: "alidade rig calibrate"; and without the program's name.
[[nodiscard]] std::string callOf(const CLI::App& app);
[[nodiscard]] std::string commandName(const CLI::App& command);

/// The complaint about a command line without something that the command needs.
[[nodiscard]] Error missingError(const std::string& command, const std::string& found,
                                 const std::string& expected);

/// The complaint about images of which none is usable ("none of them can be read"), with the message of the
/// first one's error and its next step.
[[nodiscard]] Error noneUsableError(std::size_t num_images, const std::string& complaint,
                                    const std::string& first_error);

/// `inputs` and the images that they stand for. Without the images if the inputs are at fault: reading them
/// says how.
[[nodiscard]] std::vector<std::string> withImages(std::vector<std::string> inputs);

/// "camera.yaml was not written", and whether an older file of that name is still there.
[[nodiscard]] std::string notWritten(const std::string& output);

/// The ids of all camera formats, for the flag --to.
[[nodiscard]] std::vector<std::string> formatIds();

/// Tells that the answer is no and, unless it was kept, that `output` (may be empty) was not written.
void printRefusal(const std::string& claim, const std::string& output, bool is_kept);

/// Checks before any long work that its result can go where `output` says (nothing: nowhere; "-": standard
/// output, which --json has for itself), and would overwrite none of the `sources`. These may be anything
/// that was given; what is not the path of a file is left aside. `flag` is where `output` comes from.
/// @throws Error (kUsage, kInput)
void checkOutput(const std::string& output, const std::vector<std::string>& sources,
                 const CommonOptions& options, const std::string& flag = "--output");

/// Gives the command's flags that were not given by hand the values in a settings file.
/// @throws Error (kInput) for a key that is no flag of the command, or a value it does not take
void applySettingsFile(CLI::App& app, const std::string& path);

/// The flags and values in force, without those that cannot change the result (--jobs, --quiet, ...) and
/// without the inputs, in order of name.
using Setting = std::pair<std::string, std::vector<std::string>>;
[[nodiscard]] std::vector<Setting> effectiveSettings(const CLI::App& app);

}  // namespace alidade
