// SPDX-License-Identifier: MIT
#include "alidade/report/data/json_node.h"

#include <memory>
#include <string_view>
#include <utility>

#include "alidade/camera/correction_field.h"

namespace alidade {
namespace {

constexpr int kMaxImageSide = 1'000'000;

}  // namespace

std::string validUtf8(const std::string& text) {
  const nlohmann::json value = text;
  return nlohmann::json::parse(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

std::string textOf(const JsonNode& node) {
  return node.text();
}

ImageSize readSize(const JsonNode& node) {
  const JsonNode width = node["width"];
  const JsonNode height = node["height"];
  return {.width = width.whole(1, kMaxImageSide), .height = height.whole(1, kMaxImageSide)};
}

SE3 readPose(const JsonNode& node) {
  const JsonNode quaternion = node["quaternion_xyzw"];
  const Eigen::Quaterniond q(readVector<4>(quaternion));
  return {quaternion.made([&] { return SO3::fromQuaternion(q); }), readVector<3>(node["translation_m"])};
}

Severity readSeverity(const JsonNode& node) {
  const std::string name = node.text();
  for (const Severity known : {Severity::kPass, Severity::kNote, Severity::kWarning, Severity::kFailure})
    if (severityName(known) == name) return known;
  node.refuse("pass, note, warning or failure");
}

std::vector<Diagnosis> readFindings(const JsonNode& node) {
  return node.list([](const JsonNode& finding) {
    Diagnosis diagnosis{.id = DiagnosisId::read(finding["id"].text()),
                        .severity = readSeverity(finding["severity"]),
                        .cause = finding["cause"].text()};
    diagnosis.evidence = finding["evidence"].text();
    diagnosis.next_step = finding["next_step"].text();
    diagnosis.effect_px = finding["effect_px"].number();
    return diagnosis;
  });
}

AnyCamera readCamera(const JsonNode& node) {
  const JsonNode of_model = node["model"];
  const std::string model = of_model.text();
  const JsonNode values = node["parameters"];
  std::vector<double> params;
  for (const std::string_view name : of_model.made([&] { return parameterNames(model); }))
    params.push_back(values[std::string(name).c_str()].finite());
  AnyCamera camera = values.made([&] { return AnyCamera::make(model, params); });
  if (node.has("correction") && !node["correction"].isNull()) {
    const JsonNode field = node["correction"];
    const auto pair = [&](const char* key) {
      const std::vector<double> numbers = field[key].list([](const JsonNode& n) { return n.finite(); });
      if (numbers.size() != 2) field[key].refuse("two numbers");
      return Eigen::Vector2d(numbers[0], numbers[1]);
    };
    const CorrectionGrid grid{.columns = field["columns"].whole(1, CorrectionGrid::kMaxCells),
                              .rows = field["rows"].whole(1, CorrectionGrid::kMaxCells),
                              .origin_px = pair("origin"),
                              .cell_px = pair("cell"),
                              .is_bounded = field["bounded"].flag()};
    std::vector<double> points = field["coefficients"].list([](const JsonNode& n) { return n.finite(); });
    camera = camera.withCorrection(
        field.made([&] { return std::make_shared<const CorrectionField>(grid, std::move(points)); }));
  }
  if (!node.has("entrance_pupil") || node["entrance_pupil"].isNull()) return camera;
  const JsonNode pupil = node["entrance_pupil"];
  const EntrancePupil moving{.s1_m = pupil["s1"].finite(), .s2_m = pupil["s2"].finite()};
  return pupil.made([&] {
    moving.validate();
    return camera.withPupil(moving);
  });
}

Verdict readVerdict(const JsonNode& node) {
  const auto verdict = verdictOf(node.text());
  if (!verdict) node.refuse("trustworthy, usable_with_reservations or rejected");
  return *verdict;
}

}  // namespace alidade
