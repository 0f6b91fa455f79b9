// The page is files that any web server can serve under a strict
// Content-Security-Policy: no inline script or style, nothing inlined as data.
import { defineConfig } from 'vite';

const AGENT = process.env.TREELINE_AGENT ?? 'http://127.0.0.1:8090';

export default defineConfig({
  base: './',
  build: {
    target: 'es2021',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    sourcemap: false,
    chunkSizeWarningLimit: 800,
    rollupOptions: {
      output: {
        // Libraries change seldom: browsers keep them.
        manualChunks: {
          three: ['three'],
          connect: ['@bufbuild/protobuf', '@connectrpc/connect',
            '@connectrpc/connect-web'],
        },
      },
    },
  },
  server: {
    // `npx vite` beside a running agent, for work on the page.
    proxy: { '/api': AGENT, '^/treeline[.]v1[.]': AGENT },
  },
});
