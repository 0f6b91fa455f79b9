// The page is files that treeline-server serves under a strict
// Content-Security-Policy: no inline script or style, nothing inlined as data.
import { defineConfig } from 'vite';

const SERVER = process.env.TREELINE_SERVER ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    sourcemap: false,
    chunkSizeWarningLimit: 800,
    rollupOptions: {
      input: ['index.html', 'scene.html', 'failed.html'],
      output: {
        // Libraries change seldom: browsers keep them.
        manualChunks: {
          three: ['three', 'three/addons/controls/OrbitControls.js',
            'three/addons/lines/LineSegments2.js'],
          connect: ['@bufbuild/protobuf', '@connectrpc/connect',
            '@connectrpc/connect-web'],
        },
      },
    },
  },
  server: {
    // `npx vite` beside a running server, for work on the page.
    proxy: { '^/treeline[.]v1[.]': SERVER, '^/failed-queries': SERVER },
  },
});
