#include "vir/bags/message_view.h"

#include <algorithm>
#include <cmath>

namespace vir::bags {
namespace {

std::size_t sizeOf(Kind kind) {
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

bool isNumber(Kind kind) { return kind <= Kind::float64; }

template <typename To, typename From>
To sameBits(From bits) {
  To out;
  static_assert(sizeof(To) == sizeof(From), "same size");
  std::memcpy(&out, &bits, sizeof out);
  return out;
}

double asNumber(Kind kind, std::uint64_t bits) {
  switch (kind) {
    case Kind::int8:
      return static_cast<std::int8_t>(bits);
    case Kind::int16:
      return static_cast<std::int16_t>(bits);
    case Kind::int32:
      return static_cast<std::int32_t>(bits);
    case Kind::int64:
      return static_cast<double>(static_cast<std::int64_t>(bits));
    case Kind::float32:
      return static_cast<double>(sameBits<float>(static_cast<std::uint32_t>(bits)));
    case Kind::float64:
      return sameBits<double>(bits);
    default:
      return static_cast<double>(bits);
  }
}

[[noreturn]] void failKind(std::string_view path, const char* what) {
  throw BagError("field " + std::string(path) + " is no " + what);
}

std::string_view takeText(WireCursor& c) {
  std::string_view text = c.take(c.count()).text();
  if (c.cdr() && !text.empty() && text.back() == '\0') text.remove_suffix(1);
  return text;
}

}  // namespace

WireCursor::WireCursor(ByteView bytes, Wire wire) : bytes_(bytes), cdr_(wire == Wire::cdr) {
  if (!cdr_) return;
  if (bytes.size < 4) throw BagError("the message ends before its first field");
  const int kind = bytes.data[0] << 8 | bytes.data[1];
  // Plain CDR (0, 1) and the plain form of its second version (6, 7); odd: lowest byte first.
  if (kind != 0 && kind != 1 && kind != 6 && kind != 7) {
    throw BagError("the message is in a form of CDR that is not known (" + std::to_string(kind) +
                   ")");
  }
  big_ = kind % 2 == 0;
  most_aligned_ = kind >= 6 ? 4 : 8;
  bytes_ = {bytes.data + 4, bytes.size - 4};
}

ByteView WireCursor::take(std::uint64_t size) {
  if (size > left()) throw BagError("the message ends before its last field");
  const ByteView out{bytes_.data + at_, static_cast<std::size_t>(size)};
  at_ += out.size;
  return out;
}

void WireCursor::align(std::size_t size) {
  if (!cdr_) return;
  size = std::min(size, most_aligned_);
  // Padding may be missing where nothing follows.
  at_ = std::min((at_ + size - 1) / size * size, bytes_.size);
}

std::uint64_t WireCursor::unsignedNumber(std::size_t size) {
  align(size);
  const ByteView v = take(size);
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t from = big_ ? i : size - 1 - i;
    out = out << 8 | v.data[from];
  }
  return out;
}

void WireCursor::skipElement(const Field& field) {
  if (field.type != nullptr) {
    skip(*field.type);
  } else if (field.kind == Kind::text) {
    take(count());
  } else if (field.kind == Kind::wide_text) {
    throw BagError("field " + field.name + " is a wstring, which cannot be read");
  } else if (field.kind == Kind::time || field.kind == Kind::duration) {
    take(8);
  } else {
    align(sizeOf(field.kind));
    take(sizeOf(field.kind));
  }
}

void WireCursor::skip(const Field& field) {
  if (!field.array) {
    skipElement(field);
    return;
  }
  const std::uint64_t n = field.fixed_count > 0 ? field.fixed_count : count();
  if (n == 0) return;
  const bool plain =
      field.type == nullptr && field.kind != Kind::text && field.kind != Kind::wide_text;
  std::uint64_t size = plain ? sizeOf(field.kind) : 0;
  if (field.type != nullptr && !cdr_ && field.type->ros1_fixed) {
    size = field.type->ros1_size;
    if (size == 0) return;
  }
  if (size > 0) {
    align(static_cast<std::size_t>(std::min<std::uint64_t>(size, 8)));
    if (n > left() / size) throw BagError("the message ends within the list " + field.name);
    take(n * size);
    return;
  }
  // Every element takes a byte at least (a message without fields too, in CDR).
  for (std::uint64_t i = 0; i < n; ++i) skipElement(field);
}

void WireCursor::skip(const MessageType& type) {
  if (!cdr_ && type.ros1_fixed) {
    take(type.ros1_size);
    return;
  }
  if (cdr_ && type.fields.empty()) take(1);
  for (const Field& f : type.fields) skip(f);
}

const Field* MessageView::typeOf(const MessageType& type, std::string_view path) {
  const MessageType* in = &type;
  const Field* found = nullptr;
  while (!path.empty()) {
    if (in == nullptr || (found != nullptr && found->array)) return nullptr;
    const std::size_t point = path.find('.');
    const std::string_view name = path.substr(0, point);
    found = nullptr;
    for (const Field& f : in->fields) {
      if (f.name == name) found = &f;
    }
    if (found == nullptr) return nullptr;
    in = found->type;
    path = point == std::string_view::npos ? std::string_view() : path.substr(point + 1);
  }
  return found;
}

namespace {

/// The first of them; what a file claims to have may be endless.
std::string fieldNames(const MessageType& type) {
  constexpr std::size_t kMost = 16;
  std::string out;
  for (std::size_t i = 0; i < std::min(type.fields.size(), kMost); ++i) {
    out += (i > 0 ? ", " : "") + type.fields[i].name.substr(0, 60);
  }
  return out + (type.fields.size() > kMost ? ", ..." : "");
}

}  // namespace

const Field& MessageView::seek(std::string_view path, WireCursor* cursor) const {
  const MessageType* in = type_;
  std::string_view rest = path;
  for (;;) {
    const std::size_t point = rest.find('.');
    const std::string_view name = rest.substr(0, point);
    const Field* found = nullptr;
    for (const Field& f : in->fields) {
      if (f.name == name) {
        found = &f;
        break;
      }
      cursor->skip(f);
    }
    if (found == nullptr) {
      throw BagError(type_->name + " has no field " + std::string(path) + "; " +
                     (in == type_ ? "it" : in->name) + " has " + fieldNames(*in));
    }
    if (point == std::string_view::npos) return *found;
    if (found->type == nullptr || found->array) failKind(path, "message");
    in = found->type;
    rest = rest.substr(point + 1);
  }
}

double MessageView::number(std::string_view path) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (!isNumber(f.kind) || f.array) failKind(path, "number");
  return asNumber(f.kind, c.unsignedNumber(sizeOf(f.kind)));
}

std::int64_t MessageView::integer(std::string_view path) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (!isNumber(f.kind) || f.array) failKind(path, "number");
  const std::uint64_t bits = c.unsignedNumber(sizeOf(f.kind));
  if (f.kind == Kind::int64 || f.kind == Kind::uint64) return static_cast<std::int64_t>(bits);
  const double v = asNumber(f.kind, bits);
  if (!(std::abs(v) < 9e18)) failKind(path, "whole number");
  return static_cast<std::int64_t>(v);
}

std::string_view MessageView::text(std::string_view path) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (f.kind != Kind::text || f.array) failKind(path, "text");
  return takeText(c);
}

std::vector<std::string_view> MessageView::texts(std::string_view path, std::size_t most) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (f.kind != Kind::text || !f.array) failKind(path, "list of texts");
  const std::uint64_t n = f.fixed_count > 0 ? f.fixed_count : c.count();
  if (n > most) failKind(path, "list of so few texts as are expected");
  std::vector<std::string_view> out;
  for (std::uint64_t i = 0; i < n; ++i) out.push_back(takeText(c));
  return out;
}

std::optional<TimeNs> MessageView::time(std::string_view path) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (f.array) return std::nullopt;
  const bool two_numbers = f.type != nullptr && f.type->fields.size() == 2 &&
                           sizeOf(f.type->fields[0].kind) == 4 &&
                           sizeOf(f.type->fields[1].kind) == 4;
  if (f.kind != Kind::time && !two_numbers) return std::nullopt;
  const bool is_signed = two_numbers && f.type->fields[0].kind == Kind::int32;
  const std::uint32_t seconds = c.count(), ns = c.count();
  const TimeNs whole = is_signed ? static_cast<std::int32_t>(seconds) : TimeNs{seconds};
  return whole * 1'000'000'000 + ns;
}

std::vector<double> MessageView::numbers(std::string_view path, std::size_t most) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (!f.array || !isNumber(f.kind)) failKind(path, "list of numbers");
  const std::uint64_t n = f.fixed_count > 0 ? f.fixed_count : c.count();
  if (n > most) failKind(path, "list of so few numbers as are expected");
  std::vector<double> out;
  for (std::uint64_t i = 0; i < n; ++i) {
    out.push_back(asNumber(f.kind, c.unsignedNumber(sizeOf(f.kind))));
  }
  return out;
}

ByteView MessageView::bytes(std::string_view path) const {
  WireCursor c = cursor_;
  const Field& f = seek(path, &c);
  if (!f.array || sizeOf(f.kind) != 1) failKind(path, "list of bytes");
  return c.take(f.fixed_count > 0 ? f.fixed_count : c.count());
}

void MessageView::each(std::string_view path,
                       const std::function<void(const MessageView&)>& f) const {
  WireCursor c = cursor_;
  const Field& field = seek(path, &c);
  if (!field.array || field.type == nullptr) failKind(path, "list of messages");
  const std::uint64_t n = field.fixed_count > 0 ? field.fixed_count : c.count();
  if (!c.cdr() && field.type->ros1_fixed && field.type->ros1_size == 0) return;
  for (std::uint64_t i = 0; i < n; ++i) {
    if (c.left() == 0) throw BagError("the message ends within the list " + field.name);
    f(MessageView(*field.type, c));
    c.skip(*field.type);
  }
}

}  // namespace vir::bags
