package com.google.ar.core;

import android.media.Image;
import com.google.ar.core.exceptions.NotYetAvailableException;

public class Frame {
  public long getTimestamp() {
    return 0;
  }

  public Camera getCamera() {
    return new Camera();
  }

  public Image acquireCameraImage() throws NotYetAvailableException {
    throw new NotYetAvailableException();
  }

  public Image acquireDepthImage16Bits() throws NotYetAvailableException {
    throw new NotYetAvailableException();
  }
}
