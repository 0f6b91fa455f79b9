package dev.treeline.client;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * Reads the JSON of errors and GeoPoses: objects as maps, arrays as lists,
 * numbers as doubles. Android has org.json, other Javas have nothing.
 */
final class Json {
  private static final int MAX_DEPTH = 64;
  private static final int HEX = 16;
  private static final int HEX_DIGITS = 4;

  /** It is not JSON. */
  static final class JsonException extends Exception {
    private static final long serialVersionUID = 1;

    JsonException(String message) {
      super(message);
    }
  }

  private final String text;
  private int at = 0;

  private Json(String text) {
    this.text = text;
  }

  static Object parse(String text) throws JsonException {
    Json json = new Json(text);
    Object value = json.value(0);
    json.skipBlanks();
    if (json.at != text.length()) throw json.wrong("the end");
    return value;
  }

  /** The value at a path of members; null: there is none. */
  static Object at(Object value, String... path) {
    for (String name : path) {
      if (!(value instanceof Map)) return null;
      value = ((Map<?, ?>) value).get(name);
    }
    return value;
  }

  /** As a JSON string, with its quotes. */
  static String quoted(String text) {
    StringBuilder quoted = new StringBuilder("\"");
    for (int i = 0; i < text.length(); ++i) {
      char sign = text.charAt(i);
      if (sign == '"' || sign == '\\') {
        quoted.append('\\').append(sign);
      } else if (sign < ' ') {
        quoted.append(String.format("\\u%04x", (int) sign));
      } else {
        quoted.append(sign);
      }
    }
    return quoted.append('"').toString();
  }

  private Object value(int depth) throws JsonException {
    if (depth > MAX_DEPTH) throw wrong("something less deep");
    skipBlanks();
    switch (peek()) {
      case '{': return object(depth);
      case '[': return array(depth);
      case '"': return string();
      case 't': return word("true", Boolean.TRUE);
      case 'f': return word("false", Boolean.FALSE);
      case 'n': return word("null", null);
      default: return number();
    }
  }

  private Map<String, Object> object(int depth) throws JsonException {
    Map<String, Object> members = new LinkedHashMap<>();
    expect('{');
    skipBlanks();
    if (peek() == '}') {
      ++at;
      return members;
    }
    for (;;) {
      skipBlanks();
      String name = string();
      skipBlanks();
      expect(':');
      members.put(name, value(depth + 1));
      if (ends('}')) return members;
    }
  }

  private List<Object> array(int depth) throws JsonException {
    List<Object> entries = new ArrayList<>();
    expect('[');
    skipBlanks();
    if (peek() == ']') {
      ++at;
      return entries;
    }
    for (;;) {
      entries.add(value(depth + 1));
      if (ends(']')) return entries;
    }
  }

  // After a member: the end, or a comma.
  private boolean ends(char end) throws JsonException {
    skipBlanks();
    if (peek() == end) {
      ++at;
      return true;
    }
    expect(',');
    return false;
  }

  private String string() throws JsonException {
    expect('"');
    StringBuilder read = new StringBuilder();
    for (;;) {
      char sign = peek();
      ++at;
      if (sign == '"') return read.toString();
      if (sign < ' ') throw wrong("a string without control characters");
      read.append(sign == '\\' ? escaped() : sign);
    }
  }

  private char escaped() throws JsonException {
    char sign = peek();
    ++at;
    switch (sign) {
      case 'b': return '\b';
      case 'f': return '\f';
      case 'n': return '\n';
      case 'r': return '\r';
      case 't': return '\t';
      case '"': case '\\': case '/': return sign;
      case 'u': break;
      default: throw wrong("an escape");
    }
    int code = 0;
    for (int i = 0; i < HEX_DIGITS; ++i) {
      int digit = Character.digit(peek(), HEX);
      if (digit < 0) throw wrong("four hexadecimal digits");
      code = HEX * code + digit;
      ++at;
    }
    return (char) code;
  }

  private Double number() throws JsonException {
    int start = at;
    while (at < text.length()
        && "+-.0123456789eE".indexOf(text.charAt(at)) >= 0) {
      ++at;
    }
    try {
      return Double.valueOf(text.substring(start, at));
    } catch (NumberFormatException error) {
      throw wrong("a value");
    }
  }

  private Object word(String word, Object value) throws JsonException {
    if (!text.startsWith(word, at)) throw wrong(word);
    at += word.length();
    return value;
  }

  private void skipBlanks() {
    while (at < text.length() && " \t\r\n".indexOf(text.charAt(at)) >= 0) ++at;
  }

  private char peek() throws JsonException {
    if (at >= text.length()) throw wrong("more");
    return text.charAt(at);
  }

  private void expect(char sign) throws JsonException {
    if (peek() != sign) throw wrong("'" + sign + "'");
    ++at;
  }

  private JsonException wrong(String expected) {
    return new JsonException("at " + at + ": not " + expected);
  }
}
