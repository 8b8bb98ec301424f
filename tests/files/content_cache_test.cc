// SPDX-License-Identifier: MIT
#include "alidade/files/content_cache.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include <sys/stat.h>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Cache : public ScratchTest {
 protected:
  /// The files of entries.
  [[nodiscard]] std::vector<std::string> entries() const {
    std::vector<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(path("cache"))) {
      if (entry.is_regular_file() && entry.path().filename() != "CACHEDIR.TAG") files.push_back(entry.path());
    }
    return files;
  }
};

TEST_F(Cache, KeepsTexts) {
  const std::vector<std::pair<std::string, std::string>> texts = {
      {"a", "text of a"},
      {"b", ""},
      {"", "text of nothing"},
      {std::string("a\0b", 3), std::string("\0\n\xFF", 3)}};
  {
    const ContentCache cache(path("cache"));
    for (const auto& [key, text] : texts) {
      EXPECT_EQ(cache.find(key), std::nullopt);
      cache.keep(key, text);
      EXPECT_EQ(cache.find(key), text);
    }
  }
  const ContentCache again(path("cache"));
  for (const auto& [key, text] : texts) EXPECT_EQ(again.find(key), text);
  EXPECT_EQ(again.find("c"), std::nullopt);
  EXPECT_THAT(entries(), SizeIs(4));
  EXPECT_THAT(again.complaints(), IsEmpty());
}

TEST_F(Cache, NoticesEveryChangedByte) {
  const ContentCache cache(path("cache"));
  cache.keep("key", "the text");
  const std::string file = entries().front().substr(folder_.string().size() + 1);
  const std::string bytes = scratch_.read(file);
  std::size_t num_changes = 0;
  const auto change = [&](const std::string& changed) {
    scratch_.write(file, changed);
    EXPECT_EQ(cache.find("key"), std::nullopt) << changed;
    ++num_changes;
  };
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    change(changed);
    change(bytes.substr(0, i));
  }
  change(bytes + "x");
  EXPECT_EQ(num_changes, 2 * bytes.size() + 1);
  EXPECT_THAT(cache.complaints(),
              ElementsAre(AllOf(HasSubstr(std::to_string(num_changes) + " cache entries are damaged"),
                                HasSubstr(path(file)), HasSubstr("computed again"))));
  cache.keep("key", "the text");
  EXPECT_EQ(cache.find("key"), "the text");
}

TEST_F(Cache, NoticesAnEntryUnderAnotherName) {
  const ContentCache cache(path("cache"));
  cache.keep("a", "text of a");
  const std::string file = entries().front();
  cache.keep("b", "text of b");
  for (const std::string& other : entries()) {
    if (other != file) fs::copy_file(other, file, fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(cache.find("b"), "text of b");
  EXPECT_EQ(cache.find("a"), std::nullopt);
  EXPECT_THAT(cache.complaints(), SizeIs(1));
}

TEST_F(Cache, CountsEntriesThatItsUserRejects) {
  const ContentCache cache(path("cache"));
  cache.keep("key", "nonsense");
  EXPECT_EQ(cache.find("key"), "nonsense");
  cache.reject("key");
  EXPECT_THAT(cache.complaints(), ElementsAre(AllOf(HasSubstr(entries().front()), HasSubstr("is damaged"))));
}

TEST_F(Cache, DoesNotWaitForPipes) {
  const ContentCache cache(path("cache"));
  cache.keep("key", "text");
  const std::string file = entries().front();
  fs::remove(file);
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(cache.find("key"), std::nullopt);
  EXPECT_THAT(cache.complaints(), ElementsAre(HasSubstr("is damaged")));
  fs::create_directory(path("other"));
  ASSERT_EQ(::mkfifo(path("other/CACHEDIR.TAG").c_str(), 0600), 0);
  EXPECT_THROW(ContentCache(path("other")), Error);
}

TEST_F(Cache, LeavesFoldersOfOtherFilesAlone) {
  scratch_.write("photos/a.jpg", "x");
  const auto open = [&](const std::string& name) -> std::string {
    try {
      ContentCache cache(path(name));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(open("photos"), AllOf(HasSubstr("--cache " + path("photos")),
                                    HasSubstr("a folder with other files"), HasSubstr("next: ")));
  EXPECT_THAT(scratch_.list(), ElementsAre("photos", "photos/a.jpg"));
  EXPECT_THAT(open("photos/a.jpg"), HasSubstr("--cache " + path("photos/a.jpg")));
  EXPECT_THAT(open("photos/a.jpg/cache"), HasSubstr("Not a directory"));
  // A cache of another program.
  scratch_.write("other/CACHEDIR.TAG", "Signature: 8a477f597d28d172789f06886806bc55\n");
  EXPECT_THAT(open("other"), HasSubstr("a folder with other files"));
  fs::create_directory(path("empty"));
  EXPECT_EQ(open("empty"), "");
}

TEST_F(Cache, GoesOnWhereNothingCanBeWritten) {
  const ContentCache cache(path("cache"));
  cache.keep("key", "text");
  const fs::path sub = fs::path(entries().front()).parent_path();
  fs::remove_all(sub);
  scratch_.write(sub.lexically_relative(folder_).string(), "a file in the way");
  cache.keep("key", "text");
  EXPECT_EQ(cache.find("key"), std::nullopt);
  EXPECT_THAT(cache.complaints(), ElementsAre(HasSubstr("some results are not in the cache: ")));
}

TEST_F(Cache, ServesSeveralThreadsAndPrograms) {
  const ContentCache a(path("cache"));
  const ContentCache b(path("cache"));
  constexpr std::size_t kNumKeys = 50;
  std::vector<int> num_found(kNumKeys);
  parallelFor(8 * kNumKeys, 8, [&](std::size_t i) {
    const std::string key = std::to_string(i % kNumKeys);
    const ContentCache& cache = i % 3 == 0 ? a : b;
    const auto text = cache.find(key);
    EXPECT_EQ(text.value_or("text of " + key), "text of " + key);
    cache.keep(key, "text of " + key);
  });
  for (std::size_t i = 0; i < kNumKeys; ++i) num_found[i] = a.find(std::to_string(i)).has_value() ? 1 : 0;
  EXPECT_THAT(num_found, testing::Each(1));
  EXPECT_THAT(a.complaints(), IsEmpty());
  EXPECT_THAT(b.complaints(), IsEmpty());
}

}  // namespace
}  // namespace alidade
