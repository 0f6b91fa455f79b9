package dev.treeline.client;

import dev.treeline.camera.Camera;
import dev.treeline.camera.Depth;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;

/** What is asked: one picture, and what is known of it. */
public final class LocalizeQuery {
  final byte[] file;
  final RgbImage pixels;
  final String scene;
  final List<String> candidateScenes;
  final String modelVersion;
  final Camera camera;
  final Depth depth;
  final SideUp sideUp;
  final boolean sideUpIsGuess;
  final Vector3 gravityInCameraMps2;
  final Long seed;
  final Double timeBudgetMs;
  final Double minConfidence;
  final PosePrior prior;
  final PositionPrior positionPrior;
  final HeightBand heightBand;
  final boolean wantsCorrespondences;

  private LocalizeQuery(Builder b) {
    file = b.file;
    pixels = b.pixels;
    scene = b.scene;
    candidateScenes = b.candidateScenes;
    modelVersion = b.modelVersion;
    camera = b.camera;
    depth = b.depth;
    sideUp = b.sideUp;
    sideUpIsGuess = b.sideUpIsGuess;
    gravityInCameraMps2 = b.gravityInCameraMps2;
    seed = b.seed;
    timeBudgetMs = b.timeBudgetMs;
    minConfidence = b.minConfidence;
    prior = b.prior;
    positionPrior = b.positionPrior;
    heightBand = b.heightBand;
    wantsCorrespondences = b.wantsCorrespondences;
  }

  /**
   * Of a file.
   *
   * @param file a JPEG or PNG file; not copied
   * @return what the rest is told
   */
  public static Builder of(byte[] file) {
    return new Builder(file, null);
  }

  /**
   * Of raw pixels.
   *
   * @param pixels without encoding
   * @return what the rest is told
   */
  public static Builder of(RgbImage pixels) {
    return new Builder(null, pixels);
  }

  /** A pose that is expected, of the scene's pose sensor. */
  public static final class PosePrior {
    final RigidTransform worldFromCamera;
    final double positionRadiusM;
    final double rotationRadiusRad;

    /**
     * A pose, and how far the truth may be from it.
     *
     * @param worldFromCamera expected
     * @param positionRadiusM positive
     * @param rotationRadiusRad in (0, pi]
     */
    public PosePrior(RigidTransform worldFromCamera, double positionRadiusM,
        double rotationRadiusRad) {
      this.worldFromCamera = worldFromCamera;
      this.positionRadiusM = positionRadiusM;
      this.rotationRadiusRad = rotationRadiusRad;
    }
  }

  /** A place where the camera is expected, whatever its rotation. */
  public static final class PositionPrior {
    final Vector3 positionInWorldM;
    final double radiusM;

    /**
     * A place, and how far the truth may be from it.
     *
     * @param positionInWorldM expected
     * @param radiusM positive
     */
    public PositionPrior(Vector3 positionInWorldM, double radiusM) {
      this.positionInWorldM = positionInWorldM;
      this.radiusM = radiusM;
    }
  }

  /** Heights between which the camera is expected. */
  public static final class HeightBand {
    final Vector3 upInWorld;
    final double minM;
    final double maxM;

    /**
     * A band along an axis of the world.
     *
     * @param upInWorld null: the world's z axis
     * @param minM of the camera's centre, from the world's origin
     * @param maxM more than minM
     */
    public HeightBand(Vector3 upInWorld, double minM, double maxM) {
      this.upInWorld = upInWorld;
      this.minM = minM;
      this.maxM = maxM;
    }
  }

  /** What else is known. All of it may be left out. */
  public static final class Builder {
    private final byte[] file;
    private final RgbImage pixels;
    private String scene = "";
    private List<String> candidateScenes = Collections.emptyList();
    private String modelVersion = "";
    private Camera camera;
    private Depth depth;
    private SideUp sideUp;
    private boolean sideUpIsGuess = false;
    private Vector3 gravityInCameraMps2;
    private Long seed;
    private Double timeBudgetMs;
    private Double minConfidence;
    private PosePrior prior;
    private PositionPrior positionPrior;
    private HeightBand heightBand;
    private boolean wantsCorrespondences = false;

    private Builder(byte[] file, RgbImage pixels) {
      if (file == null && pixels == null) {
        throw new NullPointerException("there is no picture");
      }
      this.file = file;
      this.pixels = pixels;
    }

    /**
     * Where it was taken. Else the server finds out.
     *
     * @param name of the scene
     * @return this
     */
    public Builder scene(String name) {
      scene = name;
      return this;
    }

    /**
     * Where it may have been taken, if no scene is named. Else in any.
     *
     * @param names of scenes
     * @return this
     */
    public Builder candidateScenes(List<String> names) {
      candidateScenes = new ArrayList<>(names);
      return this;
    }

    /**
     * Of the scene's model. Else the newest that is ready.
     *
     * @param version its name
     * @return this
     */
    public Builder modelVersion(String version) {
      modelVersion = version;
      return this;
    }

    /**
     * That took the picture. Else it is the scene's.
     *
     * @param took of the picture's size
     * @return this
     */
    public Builder camera(Camera took) {
      camera = took;
      return this;
    }

    /**
     * Measured with the picture.
     *
     * @param measured of the same moment
     * @return this
     */
    public Builder depth(Depth measured) {
      depth = measured;
      return this;
    }

    /**
     * Which side of the picture is up. It is looked for no other way.
     *
     * @param side as the picture is sent
     * @return this
     */
    public Builder sideUp(SideUp side) {
      sideUp = side;
      sideUpIsGuess = false;
      return this;
    }

    /**
     * The same, for no more than EXIF's word: the other ways are tried too.
     *
     * @param side as the picture is sent
     * @return this
     */
    public Builder sideUpGuess(SideUp side) {
      sideUp = side;
      sideUpIsGuess = true;
      return this;
    }

    /**
     * Where things fall: {@link Camera#gravityInCameraMps2}.
     *
     * @param direction in the camera's frame
     * @return this
     */
    public Builder gravityInCameraMps2(Vector3 direction) {
      gravityInCameraMps2 = direction;
      return this;
    }

    /**
     * The same seed, picture and model version give the same answer.
     *
     * @param number taken as 64 bits without a sign
     * @return this
     */
    public Builder seed(long number) {
      seed = number;
      return this;
    }

    /**
     * Most that the server may take, beside the call's own deadline.
     *
     * @param budgetMs positive
     * @return this
     */
    public Builder timeBudgetMs(double budgetMs) {
      timeBudgetMs = budgetMs;
      return this;
    }

    /**
     * Least confidence of a pose. Else it is the scene's own threshold.
     *
     * @param least in [0, 1]
     * @return this
     */
    public Builder minConfidence(double least) {
      minConfidence = least;
      return this;
    }

    /**
     * Where the camera is expected.
     *
     * @param expected and how far the truth may be
     * @return this
     */
    public Builder prior(PosePrior expected) {
      prior = expected;
      return this;
    }

    /**
     * Where the camera is expected.
     *
     * @param expected and how far the truth may be
     * @return this
     */
    public Builder positionPrior(PositionPrior expected) {
      positionPrior = expected;
      return this;
    }

    /**
     * How high the camera is expected.
     *
     * @param expected least and most
     * @return this
     */
    public Builder heightBand(HeightBand expected) {
      heightBand = expected;
      return this;
    }

    /**
     * Whether the answer says which pixels support it.
     *
     * @param wants else it does not
     * @return this
     */
    public Builder wantsCorrespondences(boolean wants) {
      wantsCorrespondences = wants;
      return this;
    }

    /**
     * The query.
     *
     * @return not to be changed
     */
    public LocalizeQuery build() {
      return new LocalizeQuery(this);
    }
  }
}
