/** Where is this camera? The client of treeline-server. */
package dev.treeline.client;
