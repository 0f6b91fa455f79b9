/** Vectors, rotations and rigid transforms. */
package dev.treeline.geometry;
