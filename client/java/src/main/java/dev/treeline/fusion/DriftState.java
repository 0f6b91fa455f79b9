package dev.treeline.fusion;

/** What is known of the world. */
public enum DriftState {
  /** Nothing. */
  SEARCHING,
  /** Fixes wait for others that agree. */
  TENTATIVE,
  /** worldFromDevice holds. */
  LOCKED,
  /** It is the last that was known, and may be wrong. */
  LOST
}
