// Reading the replay format, strictly: what formatReplay would not have written is refused.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/platform/replay.h"

namespace scree {
namespace {

constexpr uint32_t kMaxTicksPerSecond = 1000;

// A part of the file for an error line: short and printable.
std::string shown(std::string_view text) {
  constexpr size_t kShown = 40;
  std::string out;
  for (unsigned char c : text.substr(0, kShown))
    out += c >= 32 && c < 127 ? std::string(1, static_cast<char>(c)) : fmt::format("\\x{:02x}", c);
  return "'" + out + (text.size() > kShown ? "...'" : "'");
}

class Parser {
 public:
  Parser(std::string_view text, std::string_view file, const ActionMap* map)
      : text_(text), file_(file), map_(map) {}

  Result<Replay> parse() {
    if (!header() || !changes() || !end()) return Error{std::move(error_)};
    return std::move(replay_);
  }

 private:
  template <class... T>
  bool refuse(fmt::format_string<T...> format, T&&... args) {
    error_ = fmt::format("{}:{}: {}", file_, line_number_,
                         fmt::format(format, std::forward<T>(args)...));
    return false;
  }

  // Moves to the next line, without its '\n'.
  bool nextLine(std::string_view expected) {
    ++line_number_;
    if (next_ == text_.size()) return refuse("the file ends here; {} is missing", expected);
    const size_t newline = text_.find('\n', next_);
    const size_t length = std::min(newline, text_.size()) - next_;
    if (length > kMaxReplayLine)
      return refuse("a line of {} bytes; at most {} are allowed", length, kMaxReplayLine);
    line_ = text_.substr(next_, length);
    for (size_t i = 0; i < line_.size(); ++i) {
      const auto c = static_cast<unsigned char>(line_[i]);
      if (c < 32 || c == 127)
        return refuse("control character 0x{:02x} in column {}; none is allowed", c, i + 1);
    }
    if (newline == std::string_view::npos)
      return refuse("the file ends within this line: {}", shown(line_));
    next_ = newline + 1;
    return true;
  }

  // Splits the line at single spaces into exactly `count` words.
  bool words(size_t count, std::string_view form) {
    words_.clear();
    for (size_t at = 0; at <= line_.size();) {
      const size_t space = std::min(line_.find(' ', at), line_.size());
      words_.push_back(line_.substr(at, space - at));
      at = space + 1;
    }
    if (words_.size() == count) return true;
    return refuse("{} is not of the form '{}'", shown(line_), form);
  }

  // Canonical decimal only: no '+', no leading zeros.
  template <class T>
  bool number(std::string_view word, std::string_view field, T low, T high, T& value) {
    const auto [rest, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code == std::errc() && rest == word.data() + word.size() && value >= low && value <= high &&
        fmt::format("{}", value) == word)
      return true;
    return refuse("{} is {}; allowed is a whole number from {} to {}", field, shown(word), low,
                  high);
  }

  // Sixteen lower-case hexadecimal digits.
  bool digits(std::string_view word, uint64_t& value) {
    const auto [rest, code] = std::from_chars(word.data(), word.data() + word.size(), value, 16);
    if (code == std::errc() && rest == word.data() + word.size() && fmt::format("{:016x}", value) == word) return true;
    return refuse("content is {}; allowed are 16 of the digits 0 to 9 and a to f", shown(word));
  }

  bool keyword(std::string_view word) {
    if (!nextLine(fmt::format("the line '{}'", word))) return false;
    if (line_.substr(0, line_.find(' ')) == word) return true;
    return refuse("{}; expected a line that begins with '{}'", shown(line_), word);
  }

  bool header() {
    if (!keyword("scree-replay")) return false;
    if (line_ != "scree-replay 2")
      return refuse("{} is not a version that is read; allowed is 'scree-replay 2'", shown(line_));
    if (!keyword("level")) return false;
    replay_.level = line_.substr(std::min(line_.size(), sizeof("level")));
    if (replay_.level.empty() || replay_.level.size() > kMaxLevelName)
      return refuse("the level's name has {} bytes; allowed are 1 to {}", replay_.level.size(),
                    kMaxLevelName);
    if (!keyword("content") || !words(2, "content DIGITS") || !digits(words_[1], replay_.content)) return false;
    if (!keyword("rate") || !words(2, "rate TICKS_PER_SECOND") ||
        !number(words_[1], "rate", 1u, kMaxTicksPerSecond, replay_.ticks_per_second))
      return false;
    if (!keyword("seed") || !words(2, "seed NUMBER") ||
        !number<uint64_t>(words_[1], "seed", 0, UINT64_MAX, replay_.seed))
      return false;
    while (true) {
      if (!nextLine("the line 'begin'")) return false;
      if (line_ == "begin") return true;
      if (!action()) return false;
    }
  }

  bool action() {
    if (!line_.starts_with("action "))
      return refuse("{}; expected 'action NAME axis|button' or 'begin'", shown(line_));
    if (!words(3, "action NAME axis|button")) return false;
    const std::string_view name = words_[1];
    if (words_[2] != "axis" && words_[2] != "button")
      return refuse("action {} is of kind {}; allowed are axis, button", shown(name),
                    shown(words_[2]));
    const ActionKind kind = words_[2] == "axis" ? ActionKind::Axis : ActionKind::Button;
    if (replay_.actions.size() == kMaxActions) return refuse("more than {} actions", kMaxActions);
    if (find(name) < replay_.actions.size()) return refuse("action {} is given twice", shown(name));
    if (map_ && !map_->has(name)) return refuse("action {} is not one of this game", shown(name));
    if (map_ && map_->actions()[map_->id(name)].kind != kind)
      return refuse("action {} is of kind {} here, but not in this game", shown(name),
                    shown(words_[2]));
    if (!isActionName(name))
      return refuse("action {}: a name has 1 to {} lower-case letters, digits and '_'", shown(name),
                    kMaxActionName);
    replay_.actions.push_back({std::string(name), kind});
    return true;
  }

  size_t find(std::string_view name) const {
    size_t i = 0;
    while (i < replay_.actions.size() && replay_.actions[i].name != name) ++i;
    return i;
  }

  // Reads changes up to and including the line that begins with "end".
  bool changes() {
    int16_t values[kMaxActions] = {};
    uint64_t last_tick = 0;
    size_t last_action = 0;
    while (true) {
      if (!nextLine("the line 'end TICKS checksum DIGITS'")) return false;
      if (line_.starts_with("end ")) return true;
      if (!words(3, "TICK ACTION VALUE")) return false;
      ReplayChange change;
      if (!number<uint64_t>(words_[0], "tick", 1, kMaxReplayTicks, change.tick)) return false;
      if (change.tick < last_tick)
        return refuse("tick {} comes after tick {}; ticks never go back", change.tick, last_tick);
      const size_t action = find(words_[1]);
      if (action == replay_.actions.size())
        return refuse("action {} is not one of the header", shown(words_[1]));
      if (change.tick == last_tick && action <= last_action)
        return refuse("action {} of tick {} is out of the header's order", shown(words_[1]),
                      last_tick);
      const bool axis = replay_.actions[action].kind == ActionKind::Axis;
      if (!number<int16_t>(words_[2], "value", axis ? -kFullValue : 0, kFullValue, change.value))
        return false;
      if (!axis && change.value != 0 && change.value != kFullValue)
        return refuse("value of button {} is {}; allowed are 0 and {}", shown(words_[1]),
                      change.value, kFullValue);
      if (change.value == values[action])
        return refuse("action {} already has the value {}", shown(words_[1]), change.value);
      values[action] = change.value;
      last_tick = change.tick;
      last_action = action;
      change.action = static_cast<uint32_t>(action);
      replay_.changes.push_back(change);
    }
  }

  bool end() {
    if (!words(4, "end TICKS checksum DIGITS") ||
        !number<uint64_t>(words_[1], "ticks", 0, kMaxReplayTicks, replay_.ticks))
      return false;
    if (words_[2] != "checksum" || words_[3].size() != 16)
      return refuse("{} is not of the form 'end TICKS checksum DIGITS' with 16 digits",
                    shown(line_));
    if (!replay_.changes.empty() && replay_.changes.back().tick > replay_.ticks)
      return refuse("the last change is at tick {}, after the end at {}",
                    replay_.changes.back().tick, replay_.ticks);
    const size_t hashed = static_cast<size_t>(words_[3].data() - text_.data());
    const std::string checksum = fmt::format("{:016x}", hashBytes(text_.data(), hashed));
    if (words_[3] != checksum)
      return refuse("the checksum is {}, that of the content is {}: the file was changed",
                    shown(words_[3]), checksum);
    if (next_ == text_.size()) return true;
    ++line_number_;
    return refuse("{} after the end; nothing is allowed there", shown(text_.substr(next_, 41)));
  }

  std::string_view text_;
  std::string_view file_;
  const ActionMap* map_;
  Replay replay_;
  std::string error_;
  std::string_view line_;
  std::vector<std::string_view> words_;
  size_t next_ = 0;
  size_t line_number_ = 0;
};

}  // namespace

Result<Replay> parseReplay(std::string_view text, std::string_view file, const ActionMap* map) {
  return Parser(text, file, map).parse();
}

Result<Replay> readReplay(const std::filesystem::path& path, const ActionMap* map) {
  Result<std::string> text = readText(path, kMaxReplayBytes);
  if (!text) return text.takeError();
  return parseReplay(*text, path.string(), map);
}

}  // namespace scree
