// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace alidade {

/// Makes a name of 32 hexadecimal digits from bytes that come in pieces (XXH3, 128 bits). Different bytes get
/// the same name by accident with a probability of about 1e-38. It does not protect against deliberate
/// collisions.
class DigestOfParts {
 public:
  DigestOfParts();
  ~DigestOfParts();
  DigestOfParts(const DigestOfParts&) = delete;
  DigestOfParts& operator=(const DigestOfParts&) = delete;

  void add(std::string_view bytes);
  [[nodiscard]] std::string hex() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same for bytes in one piece.
[[nodiscard]] std::string digestOf(std::string_view bytes);

}  // namespace alidade
