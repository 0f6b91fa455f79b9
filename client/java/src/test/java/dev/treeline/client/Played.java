package dev.treeline.client;

import dev.treeline.proto.LocalizeResponse;
import dev.treeline.proto.NotLocalizedReason;
import dev.treeline.proto.Outcome;
import dev.treeline.proto.Pose;
import dev.treeline.proto.Quaternion;
import dev.treeline.proto.Vector3;
import java.util.ArrayList;
import java.util.List;

/** What tests of the client have in common. */
final class Played {
  static final LocalizeQuery QUERY =
      LocalizeQuery.of(new byte[] {1, 2, 3}).scene("kitchen").build();

  private Played() {}

  static LocalizeResponse.Builder localized() {
    LocalizeResponse.Builder response = LocalizeResponse.newBuilder()
        .setOutcome(Outcome.OUTCOME_LOCALIZED)
        .setWorldFromCamera(Pose.newBuilder()
            .setRotation(Quaternion.newBuilder().setW(1))
            .setTranslationM(Vector3.newBuilder().setX(1).setY(2).setZ(3)))
        .setInliers(90).setSamples(100).setInlierRatio(0.9)
        .setConfidence(0.99).setScene("kitchen").setModelVersion("2");
    for (int i = 0; i < 36; ++i) response.addCovariance(i % 7 == 0 ? 1e-4 : 0);
    return response;
  }

  static LocalizeResponse.Builder notLocalized() {
    return LocalizeResponse.newBuilder()
        .setOutcome(Outcome.OUTCOME_NOT_LOCALIZED)
        .setReason(
            NotLocalizedReason.NOT_LOCALIZED_REASON_TOO_FEW_INLIERS)
        .setInliers(3).setSamples(100).setConfidence(0.1);
  }

  static byte[] bytes(LocalizeResponse.Builder response) {
    return response.build().toByteArray();
  }

  /** A clock that only waiting moves, and no chance. */
  static final class PlayedTools implements Tools {
    final List<Long> sleptMs = new ArrayList<>();
    private long nowMs = 1000;

    @Override
    public synchronized long nowMs() {
      return nowMs;
    }

    @Override
    public synchronized void sleep(long ms, Cancellation cancellation) {
      sleptMs.add(ms);
      nowMs += ms;
    }

    @Override
    public double random() {
      return 0;
    }
  }
}
