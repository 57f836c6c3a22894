#include "vir/bags/message_definition.h"

#include <algorithm>
#include <map>
#include <set>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"

namespace vir::bags {
namespace {

constexpr std::size_t kMostTypes = 500;
constexpr std::size_t kMostFields = 2000;
constexpr int kDeepest = 24;
/// Sizes from here on are the same to us: no message is so long.
constexpr std::uint64_t kEndless = std::uint64_t{1} << 40;

/// The first word; the rest stays in `line`.
std::string_view takeWord(std::string_view* line) {
  *line = trimmed(*line);
  const std::size_t end = std::min(line->find_first_of(" \t"), line->size());
  const std::string_view word = line->substr(0, end);
  *line = trimmed(line->substr(end));
  return word;
}

struct Primitive {
  const char* name;
  Kind ros1, ros2;
};
constexpr Primitive kPrimitives[] = {
    {"bool", Kind::boolean, Kind::boolean},
    {"int8", Kind::int8, Kind::int8},
    {"uint8", Kind::uint8, Kind::uint8},
    {"int16", Kind::int16, Kind::int16},
    {"uint16", Kind::uint16, Kind::uint16},
    {"int32", Kind::int32, Kind::int32},
    {"uint32", Kind::uint32, Kind::uint32},
    {"int64", Kind::int64, Kind::int64},
    {"uint64", Kind::uint64, Kind::uint64},
    {"float32", Kind::float32, Kind::float32},
    {"float64", Kind::float64, Kind::float64},
    {"string", Kind::text, Kind::text},
    {"wstring", Kind::wide_text, Kind::wide_text},
    {"time", Kind::time, Kind::time},
    {"duration", Kind::duration, Kind::duration},
    {"byte", Kind::int8, Kind::uint8},
    {"char", Kind::uint8, Kind::uint8},
};

bool isPrimitive(std::string_view name, Wire wire, Kind* kind) {
  for (const Primitive& p : kPrimitives) {
    if (name != p.name) continue;
    *kind = wire == Wire::ros1 ? p.ros1 : p.ros2;
    // ROS 2 has messages for these.
    return wire == Wire::ros1 || (*kind != Kind::time && *kind != Kind::duration);
  }
  return false;
}

std::uint64_t ros1SizeOf(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::int8:
    case Kind::uint8:
      return 1;
    case Kind::int16:
    case Kind::uint16:
      return 2;
    case Kind::int32:
    case Kind::uint32:
    case Kind::float32:
      return 4;
    default:
      return 8;
  }
}

}  // namespace

class DefinitionParser {
 public:
  DefinitionParser(std::string type, std::string_view text, Wire wire)
      : root_(std::move(type)), wire_(wire) {
    split(text);
  }

  std::shared_ptr<const Definition> run() {
    definition_->wire_ = wire_;
    resolve(root_, texts_[root_], 0);
    return definition_;
  }

 private:
  /// Into one text per type.
  void split(std::string_view text) {
    std::string name = root_;
    std::size_t from = 0, at = 0;
    bool separator = false;
    const auto keep = [&](std::size_t to) {
      const std::string_view part = text.substr(from, to - from);
      // Some writers have a head before the first type too.
      if (name != root_ || !trimmed(part).empty()) texts_.emplace(name, part);
    };
    while (at < text.size()) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      std::string_view line = trimmed(text.substr(at, end - at));
      const std::size_t next = std::min(end + 1, text.size());
      if (line.size() >= 3 && line.find_first_not_of('=') == std::string_view::npos) {
        keep(at);
        separator = true;
        from = next;
      } else if (separator && line.substr(0, 4) == "MSG:") {
        name = shortTypeName(std::string(trimmed(line.substr(4))));
        from = next;
        separator = false;
      }
      at = next;
    }
    keep(text.size());
  }

  [[noreturn]] void fail(const std::string& type, std::string_view line, const std::string& what) {
    throw BagError("definition of " + type + ": `" + std::string(line.substr(0, 80)) +
                   "`: " + what);
  }

  const MessageType* resolve(const std::string& name, std::string_view text, int depth) {
    if (const auto known = done_.find(name); known != done_.end()) return known->second;
    if (!under_way_.insert(name).second) {
      throw BagError("definition of " + name + ": it contains itself");
    }
    if (depth > kDeepest || done_.size() >= kMostTypes) {
      throw BagError("definition of " + root_ + ": too many types within types");
    }
    definition_->types_.push_back(std::make_unique<MessageType>());
    MessageType* type = definition_->types_.back().get();
    type->name = name;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      addLine(type, text.substr(0, end), depth);
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    measure(type);
    under_way_.erase(name);
    done_[name] = type;
    return type;
  }

  void addLine(MessageType* type, std::string_view line, int depth) {
    const std::string_view whole = trimmed(line);
    std::string_view rest = whole.substr(0, whole.find('#'));
    std::string_view kind = takeWord(&rest);
    if (kind.empty()) return;
    const std::string_view name = takeWord(&rest);
    // `int32 X=1`, `int32 X = 1`: a constant is not in the bytes. (`string<=9 x` is no constant.)
    if (name.find('=') != std::string_view::npos || rest.substr(0, 1) == "=") return;
    if (name.empty()) fail(type->name, whole, "a field has a type and a name");
    if (type->fields.size() >= kMostFields) fail(type->name, whole, "too many fields");
    Field field;
    field.name = name;
    if (const std::size_t bracket = kind.find('['); bracket != std::string_view::npos) {
      field.array = true;
      std::string_view count = kind.substr(bracket + 1);
      if (count.empty() || count.back() != ']') fail(type->name, whole, "`]` is missing");
      count.remove_suffix(1);
      kind = kind.substr(0, bracket);
      if (!count.empty() && count.substr(0, 2) != "<=") {
        if (!parseNumber(count, &field.fixed_count) || field.fixed_count == 0 ||
            field.fixed_count > kEndless) {
          fail(type->name, whole, "the length of the array is no number");
        }
      }
    }
    kind = kind.substr(0, kind.find("<="));
    if (!isPrimitive(kind, wire_, &field.kind)) {
      field.kind = Kind::message;
      field.type = find(std::string(kind), *type, whole, depth);
    }
    type->fields.push_back(std::move(field));
  }

  /// A type named without its package is of the same one; `Header` is a word of its own.
  const MessageType* find(const std::string& kind, const MessageType& in, std::string_view line,
                          int depth) {
    std::string name = shortTypeName(kind);
    if (name == "Header") {
      name = "std_msgs/Header";
    } else if (name.find('/') == std::string::npos) {
      name = in.name.substr(0, in.name.find('/') + 1) + name;
    }
    const auto own = texts_.find(name);
    const std::string_view text =
        own != texts_.end() ? own->second : standardDefinition(name, wire_);
    if (own == texts_.end() && text.empty()) {
      fail(in.name, line, "the type " + name + " is described nowhere in the file");
    }
    return resolve(name, text, depth + 1);
  }

  static void measure(MessageType* type) {
    type->ros1_fixed = true;
    std::uint64_t size = 0;
    for (const Field& f : type->fields) {
      const bool open = f.kind == Kind::text || f.kind == Kind::wide_text ||
                        (f.type != nullptr && !f.type->ros1_fixed);
      if (open || (f.array && f.fixed_count == 0)) {
        type->ros1_fixed = false;
        return;
      }
      const std::uint64_t one = f.type != nullptr ? f.type->ros1_size : ros1SizeOf(f.kind);
      const std::uint64_t count = f.array ? f.fixed_count : 1;
      size += one != 0 && count > kEndless / one ? kEndless : one * count;
      size = std::min(size, kEndless);
    }
    type->ros1_size = size;
  }

  std::string root_;
  Wire wire_;
  std::map<std::string, std::string_view> texts_;
  std::map<std::string, const MessageType*> done_;
  std::set<std::string> under_way_;
  std::shared_ptr<Definition> definition_ = std::make_shared<Definition>();
};

std::shared_ptr<const Definition> Definition::parse(const std::string& type,
                                                    const std::string& text, Wire wire) {
  return DefinitionParser(shortTypeName(type), text, wire).run();
}

std::shared_ptr<const Definition> Definition::of(const Channel& channel) {
  if (channel.wire == Wire::unknown) {
    throw BagError(channel.topic + ": its messages are encoded as '" + channel.encoding +
                   "'; those of ROS 1 and CDR (ROS 2) can be read");
  }
  if (channel.definition && !channel.definition->empty()) {
    return parse(channel.type, *channel.definition, channel.wire);
  }
  const std::string_view known = standardDefinition(channel.type, channel.wire);
  if (known.empty()) {
    throw BagError(channel.topic + ": the file does not describe its type " + channel.type +
                   ", and it is no standard one; record it anew with ROS 2 Iron or later, or as "
                   "MCAP, where descriptions are in the file");
  }
  return parse(channel.type, std::string(known), channel.wire);
}

std::string shortTypeName(const std::string& type) {
  const std::size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

}  // namespace vir::bags
