package dev.treeline.client;

import java.io.File;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.util.LinkedHashMap;
import java.util.Map;

/** A file of JSON, for tests of other packages. */
public final class JsonFile {
  private JsonFile() {}

  public static Map<String, Object> read(File file) throws IOException {
    return parse(new String(
        Files.readAllBytes(file.toPath()), StandardCharsets.UTF_8));
  }

  public static Map<String, Object> parse(String text) throws IOException {
    try {
      Map<String, Object> members = new LinkedHashMap<>();
      ((Map<?, ?>) Json.parse(text)).forEach(
          (name, value) -> members.put((String) name, value));
      return members;
    } catch (Json.JsonException error) {
      throw new IOException(error);
    }
  }
}
