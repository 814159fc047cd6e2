// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a rejected input, and what messages say.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "common/base/error.hpp"

namespace cbr::test {

// The message of the InputError, or of another error, that `work`() ends with; "no error" when it
// does not.
template <class Error = InputError, class Work>
std::string refusal_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// Whether a message has all of `parts`.
template <class... Parts>
::testing::AssertionResult says(std::string_view message, const Parts&... parts) {
  if ((... && (message.find(parts) != message.npos))) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << message;
}

}  // namespace cbr::test

#define EXPECT_SAYS(...) EXPECT_TRUE(::cbr::test::says(__VA_ARGS__))
