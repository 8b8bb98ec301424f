// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

const std::string kFrom = "_from_";

std::string formComplaint(const std::string& text) {
  if (findPoseForm(text)) return "";
  return fmt::format("found '{}', expected a form of a pose\n  next: {}", text, poseFormAdvice(text));
}

std::string writtenComplaint(const std::string& text) {
  const bool are_rows = !text.empty() && std::ranges::count(poseRows(), text, &PoseRows::name) > 0;
  return are_rows ? "" : formComplaint(text);
}

std::string formHelp() {
  std::string text = "\nForms (FORM), by which a rotation or a pose is written as numbers:\n";
  for (const PoseForm& form : poseForms()) text += fmt::format("  {}: {}\n", form.name, form.help);
  text += "--to also writes rows:\n";
  for (const PoseRows& rows : poseRows()) {
    if (!rows.name.empty()) text += fmt::format("  {}: {}\n", rows.name, rows.title);
  }
  return text;
}

// a and b of "a_from_b"; both empty if the frames are unknown.
std::pair<std::string, std::string> framesIn(const NamedPose& pose) {
  const std::size_t at = pose.frames.find(kFrom);
  if (at == std::string::npos) return {};
  return {pose.frames.substr(0, at), pose.frames.substr(at + kFrom.size())};
}

NamedPose inverted(NamedPose pose) {
  const auto [a, b] = framesIn(pose);
  pose.stated = pose.stated.inverse();
  if (!a.empty()) pose.frames = b + kFrom + a;
  return pose;
}

// a_from_c = a_from_b * b_from_c, with the id of the pose that is not the same for all.
NamedPose product(const NamedPose& left, const NamedPose& right, const std::string& id) {
  const auto [a, b] = framesIn(left);
  const auto [c, d] = framesIn(right);
  if (b != c && !b.empty() && !c.empty()) {
    throw inputError({left.frames + " * " + right.frames,
                      "different frames in the middle, " + b + " and " + c, "a_from_b * b_from_c",
                      "invert one of the poses first (--invert)"});
  }
  return {.id = id,
          .stated = left.stated * right.stated,
          .frames = a.empty() || d.empty() || a == d ? "" : a + kFrom + d,
          .has_translation = left.has_translation || right.has_translation};
}

class PoseCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade pose '{quaternion_wxyz: [0.5, 0.5, 0.5, 0.5]}' --to euler_zyx_deg\nExample: alidade pose "
        "images.txt --to csv -o poses.csv\nExample: alidade pose '[[0, -1, 0], [1, 0, 0], [0, 0, 1]]' --to "
        "rotation_vector_deg\nExample: alidade pose trajectory.txt --mean\nInput: YAML, tables with a header, "
        "trajectories of TUM and KITTI, images.txt of COLMAP, transforms.json of nerfstudio,\nor numbers "
        "(docs/poses.md). A pose a_from_b takes coordinates in b to those in a. Its direction is kept, except where "
        "rows\nhave only one, which is then reported, as is gimbal lock." +
        formHelp());
    flags.add("poses", &source_,
              "A file; standard input if omitted or -; or a pose itself: YAML in braces, or numbers",
              kFilePath);
    flags.add("--to", &to_, "How poses are written: a FORM, csv, tum or kitti (below)",
              {.word = "FORM", .complaint = writtenComplaint});
    flags.add("--from", &from_, "FORM of an input that is only numbers (below)",
              {.word = "FORM", .complaint = formComplaint});
    flags.add("--poses-are", &frames_, "Direction of the input's poses, unless it states that",
              oneOf(kPoseDirections));
    flags.add("--compose", &right_, "Pose B: each pose A becomes A * B, a_from_c = a_from_b * b_from_c",
              kFilePath);
    flags.add("--relative-to", &origin_,
              "Pose B: each pose A becomes B^-1 * A, b_from_c of a_from_c and a_from_b", kFilePath);
    flags.addSwitch("--mean", is_mean_, "Write only the mean pose, and report how far the poses are from it");
    flags.addSwitch("--invert", is_inverted_, "Invert each pose, after all else");
    flags.add("-o,--output", &output_, "File for the poses instead of standard output", kFilePath);
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    checkOutput(output_, {source_, right_, origin_, common_.config}, common_);
    PoseList list = read(source_.empty() ? "-" : source_);
    if (!right_.empty()) {
      const NamedPose right = readOne("--compose", right_, list.remarks);
      for (NamedPose& pose : list.poses) pose = product(pose, right, pose.id);
    }
    if (!origin_.empty()) {
      const NamedPose origin = inverted(readOne("--relative-to", origin_, list.remarks));
      for (NamedPose& pose : list.poses) pose = product(origin, pose, pose.id);
    }
    json spread;
    if (is_mean_) spread = takeMean(list);
    if (is_inverted_) list.poses = mapped(list.poses, inverted);
    const bool has_text = !common_.json || !output_.empty();
    const std::string text = has_text ? poseText(list.poses, to_, list.remarks) : "";
    if (!common_.quiet) printNotes(list.remarks);
    if (!output_.empty() && output_ != "-") {
      writeFileAtomically(output_, text);
    } else if (!common_.json) {
      printResult(text);
    }
    answer([&] { return document(list.poses, spread); }, [] { return std::string(); });
    return 0;
  }

 private:
  [[nodiscard]] PoseList read(const std::string& source) const {
    return readAnyPoses(source, frames_, from_.empty() ? std::nullopt : findPoseForm(from_));
  }

  // --from and --poses-are do not apply to it.
  static NamedPose readOne(const std::string& flag, const std::string& source,
                           std::vector<std::string>& remarks) {
    const PoseList list = readAnyPoses(source, "", std::nullopt);
    append(remarks, list.remarks);
    if (list.poses.size() == 1) return list.poses.front();
    throw flagError(flag, fmt::format("{} poses", list.poses.size()), "one pose, which applies to all");
  }

  // Replaces the poses by their mean.
  static json takeMean(PoseList& list) {
    const NamedPose& first = list.poses.front();
    for (const NamedPose& pose : list.poses) {
      if (pose.frames != first.frames)
        throw inputError(
            {"--mean", "poses " + first.frames + " and " + pose.frames, "poses of the same frames", ""});
    }
    const PoseMean mean = meanPose(mapped(list.poses, &NamedPose::stated));
    list.remarks.push_back(fmt::format("mean of {} poses; they are {:.4g} degrees and {:.4g} m (RMS) from it",
                                       list.poses.size(), kDegPerRad * mean.rms_rad, mean.rms_m));
    if (kDegPerRad * mean.max_rad > 90)
      list.remarks.push_back(
          fmt::format("a rotation is {:.0f} degrees from the mean: another one may be as good a mean",
                      kDegPerRad * mean.max_rad));
    const json spread = {{"num_poses", list.poses.size()},
                         {"rms_angle_rad", mean.rms_rad},
                         {"max_angle_rad", mean.max_rad},
                         {"rms_distance_m", mean.rms_m}};
    list.poses = {
        {.id = "0", .stated = mean.mean, .frames = first.frames, .has_translation = first.has_translation}};
    return spread;
  }

  [[nodiscard]] std::string document(const std::vector<NamedPose>& poses, const json& spread) const {
    const PoseForm form = findPoseForm(to_).value_or(poseForms().front());
    json entries = json::array();
    for (const NamedPose& pose : poses) {
      bool gimbal_lock = false;
      const std::vector<double> numbers = form.write(pose.stated, gimbal_lock);
      entries.push_back(
          {{"id", pose.id}, {"frames", pose.frames}, {form.name, numbers}, {"gimbal_lock", gimbal_lock}});
      if (pose.has_translation) entries.back()["translation_m"] = vectorJson(pose.stated.translation);
    }
    return jsonText({{"poses", entries}, {"spread", spread}});
  }

  std::string source_;
  std::string to_ = "quaternion_xyzw";
  std::string from_;
  std::string frames_;
  std::string right_;
  std::string origin_;
  std::string output_;
  bool is_mean_ = false;
  bool is_inverted_ = false;
};

}  // namespace

const CommandEntry kPoseCommand = {"pose", "Convert rotations and poses", made<PoseCommand>};

}  // namespace alidade
