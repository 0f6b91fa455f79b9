package com.google.ar.core;

public enum TrackingState { PAUSED, STOPPED, TRACKING }
