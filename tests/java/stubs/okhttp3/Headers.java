package okhttp3;

import java.util.Collections;
import java.util.Set;

public final class Headers {
  public Set<String> names() {
    return Collections.emptySet();
  }
}
