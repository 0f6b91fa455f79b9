/** Cameras and poses, as ARCore, OpenCV and COLMAP state them. */
package dev.treeline.camera;
