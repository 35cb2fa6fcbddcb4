// Result<T>: a value, or one line that says what was wrong and what is allowed.
#pragma once

#include <cstdlib>
#include <string>
#include <utility>
#include <variant>

namespace scree {

// Whose fault an error is: a program's exit status tells them apart.
enum class ErrorKind {
  Input,    // usage, files or values that were given
  Failure,  // the machine: a full disk, no driver
};

// One line for the user: file, object, field, value, what is allowed.
struct Error {
  std::string message;
  ErrorKind kind = ErrorKind::Input;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  // The value. Calling it on an error ends the program: check ok() first.
  T& value() & { return ok() ? std::get<0>(state_) : (std::abort(), std::get<0>(state_)); }
  const T& value() const& { return ok() ? std::get<0>(state_) : (std::abort(), std::get<0>(state_)); }
  T&& value() && { return std::move(value()); }
  T* operator->() { return &value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(value()); }
  const std::string& error() const { return std::get<1>(state_).message; }
  ErrorKind errorKind() const { return std::get<1>(state_).kind; }
  Error takeError() { return std::move(std::get<1>(state_)); }

 private:
  std::variant<T, Error> state_;
};

// The result of an operation that yields nothing.
struct Done {};
using Status = Result<Done>;

}  // namespace scree
