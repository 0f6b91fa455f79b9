// One query by @treeline/client, in Node and in a browser, and its answer in
// the words of the matrix (matrix_test.py).

const bytesOf = (base64) =>
  Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

/** library: TreelineClient and TreelineError. Never throws a TreelineError. */
export async function ask({ TreelineClient, TreelineError }, request) {
  const client = new TreelineClient({
    servers: request.url,
    ...request.token === null ? {} : { token: request.token },
    maxAttempts: 1,
  });
  try {
    const answer = await client.localize({
      scene: request.scene,
      color: bytesOf(request.color),
      ...request.depth === null ? {} : { depth: {
        image: bytesOf(request.depth), unitM: 0.001,
        registration: 'scene_calibration' } },
      ...request.version === null ? {} : { modelVersion: request.version },
    }, { timeoutMs: request.timeout_ms });
    if (!answer.localized) return { outcome: answer.reason };
    const { rotation: q, translationM: t } = answer.worldFromCamera;
    return {
      outcome: 'LOCALIZED',
      pose: [q.w, q.x, q.y, q.z, t.x, t.y, t.z],
      covariance: [...answer.covariance],
      inliers: answer.inliers,
      confidence: answer.confidence,
    };
  } catch (error) {
    if (!(error instanceof TreelineError)) throw error;
    return { outcome: 'ERROR', code: error.code, reason: error.reason };
  }
}
