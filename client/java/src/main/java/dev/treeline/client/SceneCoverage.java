package dev.treeline.client;

/** Where queries will be answered. Coordinates are the plan's. */
public final class SceneCoverage {
  /** Least corner of the grid. */
  public final double minXM;
  /** Of it. */
  public final double minYM;
  /** Side of a place. */
  public final double cellM;
  /** Place (column, row) is at row * columns + column. */
  public final int columns;
  /** Along y. */
  public final int rows;
  /** At each place, evenly spread. */
  public final int headings;
  /** z of the cameras. */
  public final double heightM;
  /** z of the lowest surfaces. */
  public final double groundM;
  /** 1: a camera may well be at the place. */
  public final byte[] isOpen;
  /** Of how many headings queries will be answered. */
  public final byte[] goodHeadings;
  /** And of how many more perhaps. */
  public final byte[] weakHeadings;
  /** Of the open places. */
  public final double openM2;
  /** Of the views from them, in [0, 1]. */
  public final double goodShare;
  /** The same of those that perhaps are. */
  public final double weakShare;

  SceneCoverage(double minXM, double minYM, double cellM, int columns,
      int rows, int headings, double heightM, double groundM, byte[] isOpen,
      byte[] goodHeadings, byte[] weakHeadings, double openM2, double goodShare,
      double weakShare) {
    this.minXM = minXM;
    this.minYM = minYM;
    this.cellM = cellM;
    this.columns = columns;
    this.rows = rows;
    this.headings = headings;
    this.heightM = heightM;
    this.groundM = groundM;
    this.isOpen = isOpen;
    this.goodHeadings = goodHeadings;
    this.weakHeadings = weakHeadings;
    this.openM2 = openM2;
    this.goodShare = goodShare;
    this.weakShare = weakShare;
  }
}
