// SPDX-License-Identifier: MIT
#include "alidade/files/formats/format_guess.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include "alidade/core/text.h"
#include "alidade/files/formats/camera_format.h"

namespace alidade::detail {
namespace {

constexpr std::size_t kMaxKeys = 2000;
// Shorter words are near too many others.
constexpr std::size_t kMinNearSize = 8;
constexpr std::size_t kMaxSlip = 2;  // letters in a row that differ

struct PlacedKey {
  std::string name;
  int line = 0;
};

bool isKeyChar(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Words before a colon, in quotes or not, and the names of elements: "<name". A comment has none.
void addKeys(std::string_view line, int number, std::vector<PlacedKey>& keys) {
  for (std::size_t at = 0; at < line.size();) {
    if (line[at] == '#' && (at == 0 || line[at - 1] == ' ')) return;
    const std::size_t begin = at;
    while (at < line.size() && isKeyChar(line[at])) ++at;
    if (at == begin) {
      ++at;
      continue;
    }
    std::size_t colon = at;
    if (colon < line.size() && (line[colon] == '"' || line[colon] == '\'')) ++colon;
    while (colon < line.size() && line[colon] == ' ') ++colon;
    const bool is_element = begin > 0 && line[begin - 1] == '<';
    if (is_element || (colon < line.size() && line[colon] == ':'))
      keys.push_back({std::string(line.substr(begin, at - begin)), number});
  }
}

std::vector<PlacedKey> keysOf(const std::string& text) {
  std::vector<PlacedKey> keys;
  int number = 0;
  for (const std::string_view line : split(text, '\n')) {
    addKeys(line, ++number, keys);
    if (keys.size() > kMaxKeys) break;
  }
  return keys;
}

// The last word of "Cam1.fx" and "cam_fx".
std::string_view lastWord(std::string_view key) {
  const std::size_t at = key.find_last_of("._");
  return at == std::string_view::npos ? key : key.substr(at + 1);
}

const PlacedKey* findLastWord(const std::vector<PlacedKey>& keys, std::string_view word) {
  const auto found = std::find_if(keys.begin(), keys.end(),
                                  [&](const PlacedKey& key) { return lastWord(key.name) == word; });
  return found == keys.end() ? nullptr : &*found;
}

// Without case and underscores.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name) {
    if (c != '_') text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return text;
}

// Equal but for case, underscores and one slip.
bool isNearly(std::string_view key, std::string_view mark) {
  const std::string a = plain(key);
  const std::string b = plain(mark);
  if (a == b) return true;
  const std::size_t size = std::max(a.size(), b.size());
  if (std::min(a.size(), b.size()) < kMinNearSize) return false;
  const auto prefix =
      static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
  const auto suffix =
      static_cast<std::size_t>(std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend()).first - a.rbegin());
  constexpr std::size_t kMinPrefix = 2;  // "extrinsics" is not "intrinsics"
  return prefix >= kMinPrefix && prefix + suffix + kMaxSlip >= size;
}

struct Match {
  std::size_t num_found = 0;
  std::string missing;             // the first mark that is not there, not even nearly
  const PlacedKey* key = nullptr;  // nearly a mark, or else the first that is one
  std::string meant;
};

Match matchOf(const CameraFormat& format, const std::vector<PlacedKey>& keys) {
  Match match;
  bool has_near = false;
  for (const std::string_view mark : format.marks) {
    const auto isMark = [&](const PlacedKey& key) { return key.name == mark; };
    const auto isNear = [&](const PlacedKey& key) { return isNearly(key.name, mark); };
    auto found = std::find_if(keys.begin(), keys.end(), isMark);
    const bool is_near = found == keys.end();
    if (is_near) found = std::find_if(keys.begin(), keys.end(), isNear);
    if (found == keys.end()) {
      if (match.missing.empty()) match.missing = mark;
      continue;
    }
    ++match.num_found;
    if (match.key != nullptr && (has_near || !is_near)) continue;
    match.key = &*found;
    match.meant = mark;
    has_near = is_near;
  }
  return match;
}

bool isOwnOtherFile(const std::vector<PlacedKey>& keys) {
  return std::any_of(keys.begin(), keys.end(), [](const PlacedKey& key) {
    return key.name == "alidade_scene" || key.name == "alidade_projection";
  });
}

}  // namespace

std::optional<FormatGuess> guessFormat(const std::string& text) {
  const std::vector<PlacedKey> keys = keysOf(text);
  if (isOwnOtherFile(keys)) return std::nullopt;
  FormatGuess guess;
  std::size_t most = 0;
  for (const CameraFormat* format : cameraFormats()) {
    const Match match = matchOf(*format, keys);
    if (match.num_found <= most) continue;
    most = match.num_found;
    guess = {.format = format,
             .line = match.key->line,
             .key = match.key->name,
             .meant = match.meant,
             .missing = match.missing};
  }
  if (guess.format != nullptr) return guess;
  const PlacedKey* const fx = findLastWord(keys, "fx");
  if (fx == nullptr || findLastWord(keys, "fy") == nullptr) return std::nullopt;
  const bool is_bare = fx->name == "fx";
  return FormatGuess{.format = is_bare ? &formats::alidade() : &formats::orbslam(),
                     .line = fx->line,
                     .key = fx->name,
                     .meant = is_bare ? "fx" : "Camera1.fx",
                     .missing = is_bare ? "alidade_camera" : ""};
}

}  // namespace alidade::detail
