/** The device's own tracking and the server's fixes become one world. */
package dev.treeline.fusion;
