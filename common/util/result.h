// Errors as values: what crosses a process, file or user boundary returns Result<T>.
#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace dadrl {

// What kind of failure it was; decides the exit code (ExitCode below) and whether a retry makes sense.
enum class ErrorCode {
  kInvalidArgument,  // the user asked for something that does not exist or is out of range
  kNotFound,         // a file, checkpoint or peer that should be there is not
  kCorrupt,          // bytes were read but fail their magic, version, length or checksum
  kUnavailable,      // try again later: a peer is not there yet, a port is taken, a queue is full
  kExhausted,        // a bound was hit: disk full, memory bound, too many
  kInternal,         // anything else, including exceptions of libraries
};

// `message` is one line: what failed, the offending value, the limit, the remedy.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
};

template <typename T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

// Builds the error side of a Result: return Fail(ErrorCode::kNotFound, "no checkpoint in {}", dir);
template <typename... Args>
[[nodiscard]] tl::unexpected<Error> Fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{code, fmt::format(format, std::forward<Args>(args)...)});
}

// Process exit code of an error: 2 for wrong usage, 1 for everything else (design, section 3).
inline int ExitCode(const Error& error) { return error.code == ErrorCode::kInvalidArgument ? 2 : 1; }

// What these macros paste are declarations and names, which take no parentheses.
// NOLINTBEGIN(bugprone-macro-parentheses)

// Returns the error of `expression` (a Status) from the enclosing function. The expression may hold a lambda
// that uses the macro itself.
#define DADRL_RETURN_IF_ERROR(expression) \
  DADRL_RETURN_IF_ERROR_IMPL(DADRL_CONCAT(dadrl_status_, __COUNTER__), expression)
#define DADRL_RETURN_IF_ERROR_IMPL(status, expression)                             \
  do {                                                                             \
    auto status = (expression);                                                    \
    if (!status) return tl::unexpected<::dadrl::Error>(std::move(status.error())); \
  } while (false)

#define DADRL_CONCAT_INNER(a, b) a##b
#define DADRL_CONCAT(a, b) DADRL_CONCAT_INNER(a, b)
// DADRL_ASSIGN_OR_RETURN(auto value, MakeValue()): unwraps a Result<T> or returns its error.
#define DADRL_ASSIGN_OR_RETURN(declaration, expression) \
  DADRL_ASSIGN_OR_RETURN_IMPL(DADRL_CONCAT(dadrl_result_, __LINE__), declaration, expression)
#define DADRL_ASSIGN_OR_RETURN_IMPL(result, declaration, expression)             \
  auto result = (expression);                                                    \
  if (!result) return tl::unexpected<::dadrl::Error>(std::move(result.error())); \
  declaration = std::move(*result)

// NOLINTEND(bugprone-macro-parentheses)

}  // namespace dadrl
