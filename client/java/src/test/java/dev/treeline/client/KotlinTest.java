package dev.treeline.client;

import static org.junit.Assert.assertFalse;
import static org.junit.Assert.assertTrue;

import dev.treeline.camera.ArCore;
import dev.treeline.camera.Camera;
import dev.treeline.camera.Colmap;
import dev.treeline.camera.Depth;
import dev.treeline.camera.OpenCv;
import dev.treeline.fusion.DriftCorrector;
import dev.treeline.fusion.DriftEstimate;
import dev.treeline.fusion.DriftParameters;
import dev.treeline.fusion.Fix;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.lang.reflect.Member;
import java.lang.reflect.Modifier;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashSet;
import java.util.List;
import java.util.Set;
import org.junit.Test;

/** No name of the client needs backticks in Kotlin. */
public class KotlinTest {
  private static final Set<String> KEYWORDS = new HashSet<>(Arrays.asList(
      "as", "break", "class", "continue", "do", "else", "false", "for", "fun",
      "if", "in", "interface", "is", "null", "object", "package", "return",
      "super", "this", "throw", "true", "try", "typealias", "typeof", "val",
      "var", "when", "while"));

  @Test
  public void noNameIsAKeyword() {
    int seen = 0;
    for (Class<?> type : new Class<?>[] {ArCore.class, Camera.class,
        Colmap.class, Depth.class, OpenCv.class, DriftCorrector.class,
        DriftEstimate.class, DriftParameters.class, Fix.class,
        Quaternion.class, RigidTransform.class, Vector3.class,
        TreelineClient.class, TreelineClient.Builder.class,
        LocalizeQuery.class, LocalizeQuery.Builder.class,
        LocalizeAnswer.class, FrameQueue.class, Scene.class, SceneMap.class,
        GeoPoseQuery.class, GeoPoseAnswer.class, HttpRequest.class,
        HttpResponse.class, HttpTransport.class, Tls.class,
        TreelineException.class, TimedAnswer.class}) {
      List<Member> members = new ArrayList<>();
      members.addAll(Arrays.asList(type.getDeclaredFields()));
      members.addAll(Arrays.asList(type.getDeclaredMethods()));
      for (Member member : members) {
        if (!Modifier.isPublic(member.getModifiers())) continue;
        ++seen;
        assertFalse(type + "." + member.getName(),
            KEYWORDS.contains(member.getName()));
      }
    }
    assertTrue(seen > 150);
  }
}
