// SPDX-License-Identifier: MIT
// Results that come and go in a folder in which people keep files, against the contract of docs/files.md.
#include <array>

#include "apps/alidade/pending_folder.h"
#include "fuzz.h"
#include "support/folder_content.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

class Sequence {
 public:
  Sequence(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  void run() {
    for (int step = 0; at_ < size_ && step < kMaxSteps; ++step) {
      switch (below(4)) {
        case 0:
          addFile();
          break;
        case 1:
          removeFile();
          break;
        default:
          makeResult();
      }
    }
  }

 private:
  static constexpr int kMaxSteps = 24;
  static constexpr std::array<const char*, 6> kNames = {"camera.yaml", "corners.csv", "images/view_001.png",
                                                        "images/a b",  "list.txt",    "images"};

  std::size_t below(std::size_t limit) { return at_ < size_ ? data_[at_++] % limit : 0; }
  std::string name() { return kNames[below(kNames.size())]; }
  [[nodiscard]] std::string target() const { return scratch_.path("results"); }

  // Of people; nothing comes of it where a folder is in the way.
  void addFile() {
    const std::string path = "results/" + name();
    if (std::filesystem::is_directory(scratch_.path(path)) ||
        std::filesystem::is_regular_file(target() + "/images"))
      return;
    scratch_.write(path,
                   scratch_.has(path) && below(2) == 0 ? scratch_.read(path) : std::to_string(below(3)));
  }
  void removeFile() {
    std::error_code ignored;
    std::filesystem::remove(target() + "/" + name(), ignored);
  }

  void makeResult() {
    const std::string command = below(2) == 0 ? "simulate" : "undistort";
    const bool may_replace = below(4) != 0;
    const FolderContent before = contentOf(target());
    const bool is_allowed = before.empty() || (may_replace && last_.mayBeReplacedBy(command, before));
    bool is_accepted = false;
    FolderContent meanwhile = before;
    try {
      PendingFolder pending(target(), command, may_replace);
      is_accepted = true;
      writeEntries(pending);
      if (below(4) == 0) return expect(contentOf(target()) == before, "an interrupted run changes nothing");
      if (below(4) == 0) addFile();
      meanwhile = contentOf(target());
      pending.commit();
      expect(meanwhile.empty() || (may_replace && last_.mayBeReplacedBy(command, meanwhile)),
             "only a result that is as it was written is replaced");
      last_.set(command, contentOf(target()));
    } catch (const Error&) {
      expect(contentOf(target()) == meanwhile, "a run that is refused changes nothing");
      expect(!is_allowed || meanwhile != before, "what may be replaced is");
    }
    expect(is_accepted == is_allowed, "a result is accepted where the contract allows it");
    for (const std::string& entry : scratch_.list())
      expect(entry.starts_with("results"), "nothing is left beside the result");
  }

  // As commands do: at least one file, and no empty folder.
  void writeEntries(const PendingFolder& pending) {
    std::ofstream(pending.path("camera.yaml")) << below(3);
    const std::size_t num_images = below(3);
    if (num_images > 0) pending.makeSubfolder("images");
    for (std::size_t i = 0; i < num_images; ++i)
      std::ofstream(pending.path("images/view_00" + std::to_string(i + 1) + ".png")) << below(3);
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  ScratchFolder scratch_;
  LastResult last_;
};

}  // namespace
}  // namespace alidade

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::Sequence(data, size).run();
  return 0;
}
