// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_list.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "support/message_of.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ImageList : public ScratchTest {
 protected:
  /// The content of images does not matter here.
  void touch(const std::vector<std::string>& names) const {
    for (const std::string& name : names) scratch_.write(name, "x");
  }
  /// Lists and gives the paths without the test's folder.
  [[nodiscard]] std::vector<std::string> list(const std::vector<std::string>& names) const {
    std::vector<std::string> inputs;
    for (const std::string& name : names) inputs.push_back(path(name));
    std::vector<std::string> paths = listImages(inputs);
    for (std::string& listed : paths) listed = listed.substr(folder_.string().size() + 1);
    return paths;
  }
  [[nodiscard]] std::string errorFor(const std::string& name) const {
    std::string message = messageOf([&] { (void)list({name}); });
    EXPECT_THAT(message, AllOf(HasSubstr(path(name)), HasSubstr("next: ")));
    return message;
  }
};

TEST_F(ImageList, ListsTheImagesOfAFolderInNaturalOrder) {
  touch({"d/img10.png", "d/img2.JPG", "d/img1.tiff", "d/notes.txt", "d/.hidden.png", "d/sub/img3.png",
         "d/a.webp", "d/b.pgm", "d/img3.HEIC", "d/img4.heif"});
  fs::create_directory(folder_ / "d/folder.png");
  EXPECT_THAT(list({"d"}), ElementsAre("d/a.webp", "d/b.pgm", "d/img1.tiff", "d/img2.JPG", "d/img3.HEIC",
                                       "d/img4.heif", "d/img10.png"))
      << "reading names those that cannot be read";
}

TEST_F(ImageList, DoesNotDependOnTheOrderOfTheInputs) {
  touch({"d/a.png", "d/b.png", "e/c.png", "raw.dat"});
  fs::create_symlink("d/b.png", folder_ / "same.png");
  std::vector<std::string> inputs = {"d", "d/a.png", "d/../d/b.png", "e/*.png", "raw.dat", "d", "same.png"};
  const std::vector<std::string> expected = {"d/../d/b.png", "d/a.png", "e/c.png", "raw.dat"};
  std::sort(inputs.begin(), inputs.end());
  int num_orders = 0;
  do {
    ASSERT_EQ(list(inputs), expected);
    ++num_orders;
  } while (num_orders < 200 && std::next_permutation(inputs.begin(), inputs.end()));
  std::reverse(inputs.begin(), inputs.end());
  EXPECT_EQ(list(inputs), expected);
  EXPECT_EQ(num_orders, 200);
}

TEST_F(ImageList, ExpandsPatterns) {
  touch({"left01.png", "left02.png", "left12.png", "right01.png", "left[1].png", "sub/x.png"});
  EXPECT_THAT(list({"left0?.png"}), ElementsAre("left01.png", "left02.png"));
  EXPECT_THAT(list({"left[01]2.png"}), ElementsAre("left02.png", "left12.png"));
  EXPECT_THAT(list({"left[1].png"}), ElementsAre("left[1].png"));  // exists under this very name
  EXPECT_THAT(list({"s*"}), ElementsAre("sub/x.png"));
  EXPECT_THAT(errorFor("middle*.png"), HasSubstr("no file matches"));
}

TEST_F(ImageList, SaysWhatAFolderWithoutImagesHolds) {
  touch({"d/notes.txt", "d/table.csv", "d/right/r1.png", "d/left/l1.png", "one/notes.txt"});
  fs::create_directory(folder_ / "empty");
  EXPECT_THAT(errorFor("d"), AllOf(HasSubstr("contains 2 files, e.g. notes.txt"),
                                   HasSubstr("one level below"), HasSubstr("give '" + path("d/left") + "'")));
  EXPECT_THAT(errorFor("one"), HasSubstr("contains 1 file, notes.txt"));
  EXPECT_THAT(errorFor("empty"), HasSubstr("it is empty"));
}

TEST_F(ImageList, NamesTheNearestInput) {
  touch({"images/left01.png", "images/left02.png"});
  EXPECT_THAT(errorFor("image"), HasSubstr("did you mean '" + path("images") + "'?"));
  EXPECT_THAT(errorFor("images/left1.png"), HasSubstr("did you mean '" + path("images/left01.png") + "'?"));
  EXPECT_THAT(errorFor("images/left01.png/b.png"), HasSubstr("is a file, not a folder"));
}

TEST_F(ImageList, SaysHowToReadVideos) {
  touch({"clip.MP4"});
  EXPECT_THAT(errorFor("clip.MP4"),
              AllOf(HasSubstr("video"), HasSubstr("ffmpeg -i '" + path("clip.MP4") + "'")));
}

TEST_F(ImageList, KeepsLinksThatLeadNowhere) {
  touch({"a.png"});
  fs::create_symlink("nowhere.png", folder_ / "b.png");
  EXPECT_THAT(list({"."}), ElementsAre("./a.png", "./b.png"));
}

TEST_F(ImageList, NamesUnreadableFolders) {
  touch({"closed/a.png"});
  fs::permissions(folder_ / "closed", fs::perms::none);
  if (::geteuid() == 0) {  // reads everything
    EXPECT_THAT(list({"closed"}), ElementsAre("closed/a.png"));
  } else {
    EXPECT_THAT(errorFor("closed"), HasSubstr("Permission denied"));
    EXPECT_THAT(errorFor("closed/a.png"), HasSubstr("Permission denied"));
  }
  fs::permissions(folder_ / "closed", fs::perms::owner_all);
  EXPECT_THAT(errorFor(std::string(300, 'n')), HasSubstr("cannot be read: File name too long"));
}

TEST_F(ImageList, NeedsAnInput) {
  try {
    (void)listImages({});
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
  }
}

}  // namespace
}  // namespace alidade
