package dev.treeline.client;

import com.google.protobuf.ByteString;
import com.google.protobuf.UnsafeByteOperations;
import dev.treeline.camera.Camera;
import dev.treeline.camera.Depth;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import dev.treeline.proto.ColorImage;
import dev.treeline.proto.DepthCalibration;
import dev.treeline.proto.DepthImage;
import dev.treeline.proto.DepthRegistration;
import dev.treeline.proto.Frame;
import dev.treeline.proto.GetSceneMapResponse;
import dev.treeline.proto.HeightBand;
import dev.treeline.proto.LocalizeOptions;
import dev.treeline.proto.LocalizeRequest;
import dev.treeline.proto.LocalizeResponse;
import dev.treeline.proto.NotLocalizedReason;
import dev.treeline.proto.Orientation;
import dev.treeline.proto.Outcome;
import dev.treeline.proto.Pose;
import dev.treeline.proto.PosePrior;
import dev.treeline.proto.PositionPrior;
import dev.treeline.proto.Rgb8Image;
import dev.treeline.proto.SceneInfo;
import dev.treeline.proto.Timings;
import dev.treeline.proto.Uint16Image;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.List;
import java.util.function.Function;

/** Queries to messages, messages to answers. */
final class Convert {
  private static final int COVARIANCES = 36;
  private static final int FLOAT_BYTES = 4;
  private static final String REASON_PREFIX = "NOT_LOCALIZED_REASON_";

  private Convert() {}

  static LocalizeRequest request(LocalizeQuery query) {
    return LocalizeRequest.newBuilder()
        .setScene(query.scene)
        .addAllCandidateScenes(query.candidateScenes)
        .setModelVersion(query.modelVersion)
        .setFrame(frame(query))
        .setOptions(options(query))
        .build();
  }

  private static Frame.Builder frame(LocalizeQuery query) {
    Frame.Builder frame = Frame.newBuilder()
        .setOrientationIsGuess(query.sideUpIsGuess);
    if (query.file != null) {
      frame.setColor(ColorImage.newBuilder().setEncoded(bytes(query.file)));
    } else {
      frame.setColor(ColorImage.newBuilder().setRgb8(Rgb8Image.newBuilder()
          .setWidthPx(query.pixels.widthPx)
          .setHeightPx(query.pixels.heightPx)
          .setData(bytes(query.pixels.data))));
    }
    if (query.camera != null) frame.setCamera(camera(query.camera));
    if (query.depth != null) frame.setDepth(depth(query.depth));
    if (query.sideUp != null) frame.setOrientation(orientation(query.sideUp));
    if (query.gravityInCameraMps2 != null) {
      frame.setGravityInCameraMps2(vector(query.gravityInCameraMps2));
    }
    return frame;
  }

  private static DepthImage.Builder depth(Depth depth) {
    DepthImage.Builder made = DepthImage.newBuilder().setUnitM(depth.unitM);
    if (depth.png() != null) {
      made.setPng(bytes(depth.png()));
    } else {
      made.setRaw(Uint16Image.newBuilder().setWidthPx(depth.widthPx)
          .setHeightPx(depth.heightPx).setData(bytes(depth.raw())));
    }
    if (depth.depthScale != 0) made.setDepthScale(depth.depthScale);
    switch (depth.registration) {
      case REGISTERED_TO_COLOR:
        return made.setRegistration(
            DepthRegistration.DEPTH_REGISTRATION_REGISTERED_TO_COLOR);
      case SCENE_CALIBRATION:
        return made.setRegistration(
            DepthRegistration.DEPTH_REGISTRATION_SCENE_CALIBRATION);
      default:
        return made
            .setRegistration(DepthRegistration.DEPTH_REGISTRATION_EXPLICIT)
            .setCalibration(DepthCalibration.newBuilder()
                .setDepthCamera(camera(depth.camera))
                .setColorFromDepth(pose(depth.colorFromDepth)));
    }
  }

  private static LocalizeOptions.Builder options(LocalizeQuery query) {
    LocalizeOptions.Builder options = LocalizeOptions.newBuilder()
        .setIncludeCorrespondences(query.wantsCorrespondences);
    if (query.seed != null) options.setSeed(query.seed);
    if (query.timeBudgetMs != null) options.setTimeBudgetMs(query.timeBudgetMs);
    if (query.minConfidence != null) {
      options.setMinConfidence(query.minConfidence);
    }
    if (query.prior != null) {
      options.setPrior(PosePrior.newBuilder()
          .setWorldFromCamera(pose(query.prior.worldFromCamera))
          .setPositionRadiusM(query.prior.positionRadiusM)
          .setRotationRadiusRad(query.prior.rotationRadiusRad));
    }
    if (query.positionPrior != null) {
      options.setPositionPrior(PositionPrior.newBuilder()
          .setPositionInWorldM(vector(query.positionPrior.positionInWorldM))
          .setRadiusM(query.positionPrior.radiusM));
    }
    if (query.heightBand != null) {
      HeightBand.Builder band = HeightBand.newBuilder()
          .setMinM(query.heightBand.minM).setMaxM(query.heightBand.maxM);
      if (query.heightBand.upInWorld != null) {
        band.setUpInWorld(vector(query.heightBand.upInWorld));
      }
      options.setHeightBand(band);
    }
    return options;
  }

  private static Orientation orientation(SideUp side) {
    switch (side) {
      case TOP: return Orientation.ORIENTATION_TOP_UP;
      case RIGHT: return Orientation.ORIENTATION_RIGHT_UP;
      case BOTTOM: return Orientation.ORIENTATION_BOTTOM_UP;
      default: return Orientation.ORIENTATION_LEFT_UP;
    }
  }

  private static ByteString bytes(byte[] shared) {
    return UnsafeByteOperations.unsafeWrap(shared);
  }

  private static dev.treeline.proto.Camera.Builder camera(Camera camera) {
    dev.treeline.proto.Camera.Builder made =
        dev.treeline.proto.Camera.newBuilder().setModel(camera.model)
            .setWidthPx(camera.widthPx).setHeightPx(camera.heightPx);
    for (double parameter : camera.parameters()) made.addParameters(parameter);
    return made;
  }

  private static dev.treeline.proto.Vector3.Builder vector(Vector3 v) {
    return dev.treeline.proto.Vector3.newBuilder()
        .setX(v.x).setY(v.y).setZ(v.z);
  }

  private static Pose.Builder pose(RigidTransform transform) {
    Quaternion q = transform.rotation;
    return Pose.newBuilder()
        .setRotation(dev.treeline.proto.Quaternion.newBuilder()
            .setW(q.w).setX(q.x).setY(q.y).setZ(q.z))
        .setTranslationM(vector(transform.translationM));
  }

  static LocalizeAnswer answer(LocalizeResponse r, long roundTripMs)
      throws TreelineException {
    if (r.getOutcome() == Outcome.OUTCOME_LOCALIZED) {
      if (r.getCovarianceCount() != COVARIANCES) {
        throw internal(
            "the server sent " + r.getCovarianceCount() + " covariances");
      }
      return new LocalizeAnswer(
          r, transform(r.getWorldFromCamera()), "", roundTripMs);
    }
    if (r.getOutcome() == Outcome.OUTCOME_NOT_LOCALIZED) {
      // A newer server may have reasons that have no name here.
      String reason = r.getReason() == NotLocalizedReason.UNRECOGNIZED
          ? "REASON_" + r.getReasonValue()
          : r.getReason().name().substring(REASON_PREFIX.length());
      return new LocalizeAnswer(r, null, reason, roundTripMs);
    }
    throw internal("the server sent no outcome");
  }

  static SceneCandidate candidate(dev.treeline.proto.SceneCandidate c) {
    return new SceneCandidate(c.getScene(), c.getSimilarity(), c.getTried(),
        c.getOutcome() == Outcome.OUTCOME_LOCALIZED, c.getConfidence(),
        c.getInliers());
  }

  static Correspondence correspondence(dev.treeline.proto.Correspondence c) {
    return new Correspondence(c.getColorPixel().getXPx(),
        c.getColorPixel().getYPx(), vector(c.getPointInCameraM()),
        vector(c.getPointInWorldM()), c.getInlier());
  }

  static ServerTimings timings(Timings t) {
    return new ServerTimings(t.getQueueMs(), t.getDecodeMs(), t.getSampleMs(),
        t.getForestMs(), t.getPoseMs(), t.getLocalizeMs(), t.getTotalMs());
  }

  static Scene scene(SceneInfo s) {
    boolean answers = s.hasModel();
    List<String> versions = each(
        s.getVersionsList(), dev.treeline.proto.ModelVersion::getVersion);
    String failure = s.hasFailure()
        ? s.getFailure().getCode() + ": " + s.getFailure().getMessage() : "";
    Camera camera = s.hasDefaultCamera() ? camera(s.getDefaultCamera())
        : answers && s.getModel().getCalibration().hasColor()
            ? camera(s.getModel().getCalibration().getColor()) : null;
    boolean hasBounds = answers && s.getModel().hasBoundsMinInWorldM();
    return new Scene(s.getScene(), state(s.getState()), failure,
        s.getModelVersion(), versions, s.getDisplayName(),
        answers ? s.getModel().getMethod() : null, camera,
        hasBounds ? vector(s.getModel().getBoundsMinInWorldM()) : null,
        hasBounds ? vector(s.getModel().getBoundsMaxInWorldM()) : null,
        s.hasGeoAnchor() ? anchor(s.getGeoAnchor()) : null);
  }

  private static SceneState state(dev.treeline.proto.SceneState state) {
    switch (state) {
      case SCENE_STATE_UNLOADED: return SceneState.UNLOADED;
      case SCENE_STATE_LOADING: return SceneState.LOADING;
      case SCENE_STATE_READY: return SceneState.READY;
      case SCENE_STATE_FAILED: return SceneState.FAILED;
      default: return SceneState.UNKNOWN;
    }
  }

  private static GeoAnchor anchor(dev.treeline.proto.GeoAnchor a) {
    return new GeoAnchor(a.getLatitudeDeg(), a.getLongitudeDeg(),
        a.getHeightM(), a.hasEnuFromWorld() ? quaternion(a.getEnuFromWorld())
            : Quaternion.IDENTITY);
  }

  static SceneMap sceneMap(GetSceneMapResponse m) throws TreelineException {
    if (m.getPointsInWorldM().size()
        != 3 * FLOAT_BYTES * m.getBrightness().size()) {
      throw internal("the server sent points without brightness");
    }
    float[] points = new float[3 * m.getBrightness().size()];
    m.getPointsInWorldM().asReadOnlyByteBuffer()
        .order(ByteOrder.LITTLE_ENDIAN).asFloatBuffer().get(points);
    List<RigidTransform> keyframes = new ArrayList<>();
    for (Pose pose : m.getWorldFromKeyframeList()) {
      keyframes.add(transform(pose));
    }
    return new SceneMap(m.getScene(), m.getModelVersion(), points,
        m.getBrightness().toByteArray(), m.getPointsInModel(), keyframes,
        m.hasCamera() ? camera(m.getCamera()) : null,
        m.hasPlanFromWorld() ? quaternion(m.getPlanFromWorld())
            : Quaternion.IDENTITY,
        m.hasCoverage() ? coverage(m.getCoverage()) : null);
  }

  private static SceneCoverage coverage(dev.treeline.proto.SceneCoverage c)
      throws TreelineException {
    for (ByteString places : new ByteString[] {
        c.getIsOpen(), c.getGoodHeadings(), c.getWeakHeadings()}) {
      if (places.size() != (long) c.getColumns() * c.getRows()) {
        throw internal("the server sent " + places.size() + " of "
            + c.getColumns() + " x " + c.getRows() + " places");
      }
    }
    return new SceneCoverage(c.getMinXM(), c.getMinYM(), c.getCellM(),
        c.getColumns(), c.getRows(), c.getHeadings(), c.getHeightM(),
        c.getGroundM(), c.getIsOpen().toByteArray(),
        c.getGoodHeadings().toByteArray(), c.getWeakHeadings().toByteArray(),
        c.getOpenM2(), c.getGoodShare(), c.getWeakShare());
  }

  static RecentQuery recentQuery(dev.treeline.proto.RecentQuery q)
      throws TreelineException {
    return new RecentQuery(q.getTimeUtc(),
        q.hasWorldFromCamera() ? transform(q.getWorldFromCamera()) : null,
        q.getReason(), q.getIsError(), q.getConfidence(), q.getInliers(),
        q.getSamples(), q.getTotalMs());
  }

  // Never a pose that was not said; bit for bit what the server computed.
  private static RigidTransform transform(Pose pose) throws TreelineException {
    if (!pose.hasRotation()) {
      throw internal("the server sent a pose without one");
    }
    return new RigidTransform(
        quaternion(pose.getRotation()), vector(pose.getTranslationM()));
  }

  private static Quaternion quaternion(dev.treeline.proto.Quaternion q) {
    return new Quaternion(q.getW(), q.getX(), q.getY(), q.getZ());
  }

  private static Vector3 vector(dev.treeline.proto.Vector3 v) {
    return new Vector3(v.getX(), v.getY(), v.getZ());
  }

  static Camera camera(dev.treeline.proto.Camera c) {
    return new Camera(c.getModel(), c.getWidthPx(), c.getHeightPx(),
        doubles(c.getParametersList()));
  }

  static double[] doubles(List<Double> list) {
    double[] values = new double[list.size()];
    for (int i = 0; i < values.length; ++i) values[i] = list.get(i);
    return values;
  }

  static <A, B> List<B> each(List<A> all, Function<A, B> made) {
    List<B> list = new ArrayList<>();
    for (A one : all) list.add(made.apply(one));
    return list;
  }

  private static TreelineException internal(String message) {
    return new TreelineException(ErrorCode.INTERNAL, message);
  }
}
