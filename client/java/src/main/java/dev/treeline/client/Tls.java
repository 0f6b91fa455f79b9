package dev.treeline.client;

import java.io.IOException;
import java.io.InputStream;
import java.security.GeneralSecurityException;
import java.security.KeyStore;
import java.security.cert.Certificate;
import java.security.cert.CertificateFactory;
import java.util.Collection;
import javax.net.ssl.KeyManagerFactory;
import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLSocketFactory;
import javax.net.ssl.TrustManagerFactory;

/** TLS with certificates of one's own, for {@link TreelineClient.Builder#tls}.
 */
public final class Tls {
  private Tls() {}

  /**
   * Trusts these authorities instead of the system's. The name in the server's
   * certificate is still checked.
   *
   * @param authorities one or more certificates, PEM or DER, as of a raw
   *     resource; it is read, not closed
   * @return for the client
   * @throws IOException if it cannot be read
   * @throws GeneralSecurityException if there are no certificates in it
   */
  public static SSLSocketFactory trusting(InputStream authorities)
      throws IOException, GeneralSecurityException {
    return of(authorities, null, new char[0]);
  }

  /**
   * The same with a certificate of the client's, for servers that ask.
   *
   * @param authorities as above
   * @param clientKey a PKCS #12 file with its certificate and key
   * @param password of that file
   * @return for the client
   * @throws IOException if one cannot be read
   * @throws GeneralSecurityException if it has not what it should
   */
  public static SSLSocketFactory trusting(InputStream authorities,
      InputStream clientKey, char[] password)
      throws IOException, GeneralSecurityException {
    return of(authorities, clientKey, password);
  }

  private static SSLSocketFactory of(InputStream authorities,
      InputStream clientKey, char[] password)
      throws IOException, GeneralSecurityException {
    Collection<? extends Certificate> certificates =
        CertificateFactory.getInstance("X.509")
            .generateCertificates(authorities);
    if (certificates.isEmpty()) {
      throw new GeneralSecurityException("there is no certificate in it");
    }
    KeyStore trusted = KeyStore.getInstance(KeyStore.getDefaultType());
    trusted.load(null, null);
    int count = 0;
    for (Certificate certificate : certificates) {
      trusted.setCertificateEntry("authority-" + count++, certificate);
    }
    TrustManagerFactory trust = TrustManagerFactory.getInstance(
        TrustManagerFactory.getDefaultAlgorithm());
    trust.init(trusted);
    KeyManagerFactory keys = null;
    if (clientKey != null) {
      KeyStore own = KeyStore.getInstance("PKCS12");
      own.load(clientKey, password);
      keys = KeyManagerFactory.getInstance(
          KeyManagerFactory.getDefaultAlgorithm());
      keys.init(own, password);
    }
    SSLContext context = SSLContext.getInstance("TLS");
    context.init(keys == null ? null : keys.getKeyManagers(),
        trust.getTrustManagers(), null);
    return context.getSocketFactory();
  }
}
