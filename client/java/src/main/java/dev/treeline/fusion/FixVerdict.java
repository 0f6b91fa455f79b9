package dev.treeline.fusion;

/** What became of a fix. */
public enum FixVerdict {
  /** It corrected the world. */
  APPLIED,
  /** With it the world began. */
  LOCKED,
  /** With it others won over the world that was. */
  JUMPED,
  /** It waits for others that agree. */
  HELD,
  /** Too little confidence. */
  IGNORED_CONFIDENCE,
  /** Too uncertain. */
  IGNORED_UNCERTAIN,
  /** Captured when nothing was tracked. */
  IGNORED_UNTRACKED,
  /** Of a picture that has counted already. */
  IGNORED_REPEATED
}
