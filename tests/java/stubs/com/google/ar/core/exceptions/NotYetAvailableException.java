package com.google.ar.core.exceptions;

public class NotYetAvailableException extends Exception {
  private static final long serialVersionUID = 1;
}
