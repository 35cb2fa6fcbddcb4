// #include, #line and defines for GLSL.
#include "engine/gpu/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "engine/core/file.h"

namespace scree::gpu {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxShaderBytes = 4ull << 20;
constexpr std::string_view kPrologueName = "prologue";

std::string_view trim(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())))
    text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
    text.remove_suffix(1);
  return text;
}

// Splits "#  name rest": the name is empty if the line is no directive.
struct Directive {
  std::string_view name, rest;
};
Directive directive(std::string_view line) {
  line = trim(line);
  if (line.empty() || line.front() != '#') return {};
  line = trim(line.substr(1));
  size_t end = 0;
  while (end < line.size() && std::isalpha(static_cast<unsigned char>(line[end]))) ++end;
  return {line.substr(0, end), trim(line.substr(end))};
}

// The line without comments; `in_comment` carries /* */ from line to line. Comments become one
// space, as in GLSL.
std::string withoutComments(std::string_view line, bool& in_comment) {
  std::string kept;
  for (size_t i = 0; i < line.size(); ++i) {
    const std::string_view pair = line.substr(i, 2);
    if (in_comment) {
      if (pair == "*/") {
        in_comment = false;
        ++i;
      }
    } else if (pair == "//") {
      break;
    } else if (pair == "/*") {
      in_comment = true;
      kept += ' ';
      ++i;
    } else {
      kept += line[i];
    }
  }
  return kept;
}

// "__cplusplus" or "defined(__cplusplus)", with any spaces; sets `negated` for a leading "!".
bool testsCpp(const Directive& d, bool& negated) {
  std::string condition;
  for (char c : d.rest)
    if (!std::isspace(static_cast<unsigned char>(c))) condition += c;
  negated = d.name == "ifndef";
  if (d.name == "ifdef" || d.name == "ifndef") return condition == "__cplusplus";
  if (d.name != "if") return false;
  if (!condition.empty() && condition.front() == '!') {
    negated = true;
    condition.erase(0, 1);
  }
  return condition == "defined(__cplusplus)" || condition == "defined__cplusplus";
}

class Assembler {
 public:
  Assembler(const fs::path& root, std::vector<std::string>* read) : root_(root), read_(read) {}

  Status addFile(std::string_view path, std::string_view included_from) {
    const std::string name = fs::path(path).lexically_normal().generic_string();
    auto refuse = [&](std::string_view what) {
      return Error{included_from.empty()
                       ? fmt::format("{}: {}", name, what)
                       : fmt::format("{}: #include \"{}\": {}", included_from, name, what)};
    };
    if (name.empty() || name == "." || name.front() == '/' || name.starts_with(".."))
      return refuse("paths must lie below the shader root");
    if (std::find(stack_.begin(), stack_.end(), name) != stack_.end()) {
      std::string chain;
      for (const std::string& file : stack_) chain += file + " -> ";
      return refuse(fmt::format("a cycle: {}{}", chain, name));
    }
    // Number 0 is the prologue, which no #include can name.
    if (std::find(out_.files.begin() + 1, out_.files.end(), name) != out_.files.end())
      return Done{};
    if (stack_.size() >= static_cast<size_t>(kMaxIncludeDepth))
      return refuse(fmt::format("includes nest deeper than {}", kMaxIncludeDepth));
    if (read_ && std::find(read_->begin(), read_->end(), name) == read_->end())
      read_->push_back(name);
    Result<std::string> text = readText(root_ / name, kMaxShaderBytes);
    if (!text.ok()) return refuse(text.error());

    const size_t number = out_.files.size();
    out_.files.push_back(name);
    stack_.push_back(name);
    line(1, number);
    const Status added = addLines(*text, name, number);
    stack_.pop_back();
    return added;
  }

  ShaderSource out_;

 private:
  struct Conditional {
    bool cpp = false;    // tests __cplusplus
    bool active = true;  // in a GLSL section of such a test
    int line = 0;
  };

  void line(size_t line_number, size_t file_number) {
    out_.text +=
        fmt::format("#line {} {}\n", file_number * kLinesPerFile + line_number, file_number);
  }

  Status addLines(std::string_view text, const std::string& name, size_t number) {
    std::vector<Conditional> open;
    bool in_comment = false;
    int line_number = 0;
    while (!text.empty()) {
      const size_t end = text.find('\n');
      std::string_view raw = text.substr(0, end);
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      if (++line_number >= kLinesPerFile)
        return Error{fmt::format("{}: more than {} lines", name, kLinesPerFile - 1)};
      if (!raw.empty() && raw.back() == '\r') raw.remove_suffix(1);
      const std::string code = withoutComments(raw, in_comment);
      Result<bool> kept = handle(directive(code), open, name, number, line_number);
      if (!kept.ok()) return Error{kept.error()};
      // Comments are dropped, so that a directive in one cannot confuse a driver's preprocessor.
      if (*kept) out_.text += code;
      out_.text += '\n';
    }
    if (!open.empty())
      return Error{fmt::format("{}:{}: #if without #endif", name, open.back().line)};
    if (in_comment) return Error{fmt::format("{}:{}: comment without end", name, line_number)};
    return Done{};
  }

  // True if the line is part of the GLSL source.
  Result<bool> handle(const Directive& d, std::vector<Conditional>& open, const std::string& name,
                      size_t number, int line_number) {
    auto at = [&](std::string_view what) {
      return Error{fmt::format("{}:{}: {}", name, line_number, what)};
    };
    const bool active =
        std::all_of(open.begin(), open.end(), [](const Conditional& c) { return c.active; });
    if (d.name == "if" || d.name == "ifdef" || d.name == "ifndef") {
      bool negated = false;
      const bool cpp = testsCpp(d, negated);
      open.push_back({cpp, cpp ? negated : true, line_number});
      return active && !cpp;
    }
    if (d.name == "else" || d.name == "elif" || d.name == "endif") {
      if (open.empty()) return at(fmt::format("#{} without #if", d.name));
      Conditional& top = open.back();
      const bool cpp = top.cpp;
      if (cpp && d.name == "elif") return at("#elif after a test of __cplusplus");
      if (cpp && d.name == "else") top.active = !top.active;
      if (d.name == "endif") open.pop_back();
      return !cpp && active;
    }
    if (!active) return false;
    if (d.name == "version") return at("#version is set by the engine (450 core)");
    if (d.name == "pragma" && d.rest == "once") return false;
    if (d.name != "include") return true;

    const bool quoted =
        d.rest.size() > 2 && d.rest.front() == '"' && d.rest.find('"', 1) == d.rest.size() - 1;
    if (!quoted) return at("#include takes one path in quotation marks");
    if (std::any_of(open.begin(), open.end(), [](const Conditional& c) { return !c.cpp; }))
      return at(
          "#include inside #if: a file is included once, so it could vanish; include it outside");
    std::string_view path = d.rest.substr(1, d.rest.size() - 2);
    if (path.starts_with("shaders/")) path.remove_prefix(8);
    if (Status added = addFile(path, fmt::format("{}:{}", name, line_number)); !added.ok())
      return Error{added.error()};
    // This line itself becomes the empty line after which numbering goes on.
    line(static_cast<size_t>(line_number), number);
    return false;
  }

  const fs::path& root_;
  std::vector<std::string>* read_;
  std::vector<std::string> stack_;
};

std::string_view stageDefine(ShaderStage stage) {
  switch (stage) {
    case ShaderStage::Vertex:
      return "VERTEX_STAGE";
    case ShaderStage::Fragment:
      return "FRAGMENT_STAGE";
    case ShaderStage::Compute:
      return "COMPUTE_STAGE";
  }
  return "";
}

size_t digits(std::string_view text) {
  size_t count = 0;
  while (count < text.size() && std::isdigit(static_cast<unsigned char>(text[count]))) ++count;
  return count;
}

int toInt(std::string_view text) {
  int value = 0;
  for (char c : text.substr(0, 9)) value = value * 10 + (c - '0');
  return value;
}

}  // namespace

Result<ShaderSource> assembleShader(const fs::path& root, std::string_view path, ShaderStage stage,
                                    std::span<const std::string> defines,
                                    std::vector<std::string>* read) {
  Assembler assembler(root, read);
  ShaderSource& out = assembler.out_;
  out.files.emplace_back(kPrologueName);
  out.text = fmt::format("#version 450 core\n#define {} 1\n", stageDefine(stage));
  for (const std::string& define : defines) {
    if (define.empty() || define.find('\n') != std::string::npos)
      return Error{fmt::format("{}: define '{}' is not \"NAME\" or \"NAME VALUE\"", path, define)};
    out.text += fmt::format("#define {}\n", define);
  }
  if (Status added = assembler.addFile(path, ""); !added.ok()) return Error{added.error()};
  return std::move(out);
}

std::string nameFilesInLog(std::string_view log, std::span<const std::string> files) {
  std::string named;
  while (!log.empty()) {
    const size_t end = log.find('\n');
    std::string_view row = log.substr(0, end);
    log.remove_prefix(end == std::string_view::npos ? log.size() : end + 1);
    if (!row.empty() && row.back() == '\0') row.remove_suffix(1);
    std::string_view rest = row;
    for (std::string_view prefix : {"ERROR: ", "WARNING: "})
      if (rest.starts_with(prefix)) rest.remove_prefix(prefix.size());
    // file:line or file(line), then an optional (column), then the message.
    const size_t file_digits = digits(rest);
    if (file_digits > 0 && file_digits < rest.size()) {
      size_t file = static_cast<size_t>(toInt(rest.substr(0, file_digits)));
      const char separator = rest[file_digits];
      std::string_view after = rest.substr(file_digits + 1);
      const size_t line_digits = digits(after);
      int line = toInt(after.substr(0, line_digits));
      if (line >= kLinesPerFile) {
        file = static_cast<size_t>(line / kLinesPerFile);
        line %= kLinesPerFile;
      }
      if (file < files.size() && line_digits > 0 && (separator == ':' || separator == '(')) {
        after.remove_prefix(line_digits);
        if (after.starts_with('('))
          after.remove_prefix(std::min(after.find(')'), after.size() - 1) + 1);
        while (!after.empty() &&
               (after.front() == ')' || after.front() == ':' || after.front() == ' '))
          after.remove_prefix(1);
        named += fmt::format("{}:{}: {}\n", files[file], line, after);
        continue;
      }
    }
    if (!trim(row).empty()) named += fmt::format("{}\n", row);
  }
  if (!named.empty()) named.pop_back();
  return named;
}

}  // namespace scree::gpu
