package dev.treeline.client;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertThrows;

import java.util.Arrays;
import org.junit.Test;

public class JsonTest {
  @Test
  public void valuesAreRead() throws Exception {
    Object value = Json.parse(" {\"a\": [1, -2.5e1, true, false, null, {}],"
        + " \"b\\u00e9\\n\\\"\": \"\\/\", \"c\": []} ");
    assertEquals(Arrays.asList(1.0, -25.0, true, false, null,
        Json.parse("{}")), Json.at(value, "a"));
    assertEquals("/", Json.at(value, "b\u00e9\n\""));
    assertNull(Json.at(value, "a", "b"));
    assertEquals("x", Json.parse("\"x\""));
  }

  @Test
  public void whatIsNoJsonIsRefused() {
    StringBuilder deep = new StringBuilder();
    for (int i = 0; i < 100_000; ++i) deep.append('[');
    for (String bad : new String[] {"", "{", "[1,]", "{\"a\"}", "{a:1}", "tru",
        "1 2", "\"", "\"\\x\"", "\"\\u12g4\"", "'a'", "-", "\"a\nb\"",
        "<html>", "1d", "NaN", deep.toString()}) {
      assertThrows(bad, Json.JsonException.class, () -> Json.parse(bad));
    }
  }

  @Test
  public void whatIsQuotedComesBack() throws Exception {
    String hard = "a\"b\\c\n\u0001\u00e9";
    assertEquals(hard, Json.parse(Json.quoted(hard)));
  }
}
