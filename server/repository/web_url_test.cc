#include "server/repository/web_url.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

TEST(WebUrl, ResolvesAsRfc3986Says) {
  const std::string base = "https://h:8443/a/index.json?sig=1";
  EXPECT_EQ(ResolveUrl(base, "k/7/model.treeline").value(),
            "https://h:8443/a/k/7/model.treeline");
  EXPECT_EQ(ResolveUrl(base, "../b").value(), "https://h:8443/b");
  EXPECT_EQ(ResolveUrl(base, "/b?c=d").value(), "https://h:8443/b?c=d");
  EXPECT_EQ(ResolveUrl(base, "https://other/x?y#z").value(),
            "https://other/x?y");
  EXPECT_EQ(ResolveUrl("", "http://h/x").value(), "http://h/x");
}

TEST(WebUrl, OnlyWebServersAreAddressed) {
  for (const char* url : {"file:///etc/passwd", "ftp://h/x", "x/y", "",
                          "http://", "https://a b/", "gopher://h"}) {
    EXPECT_FALSE(ResolveUrl("", url).ok()) << url;
  }
  EXPECT_FALSE(ResolveUrl("https://h/", "file:///etc/passwd").ok());
}

TEST(WebUrl, WhatIsShownHoldsNoSecrets) {
  EXPECT_EQ(PublicUrl("https://user:pass@h:1/a/b?sig=SECRET#f"),
            "https://h:1/a/b");
  EXPECT_EQ(PublicUrl("no address: SECRET"), "(an address)");
}

TEST(WebUrl, PlainHttpIsForThisMachineUnlessAllowed) {
  EXPECT_TRUE(CheckTransport("https://h/x", false).ok());
  EXPECT_TRUE(CheckTransport("http://127.0.0.1:80/x", false).ok());
  EXPECT_TRUE(CheckTransport("http://[::1]/x", false).ok());
  EXPECT_TRUE(CheckTransport("http://localhost/x", false).ok());
  EXPECT_TRUE(CheckTransport("http://h/x", true).ok());
  EXPECT_FALSE(CheckTransport("http://h/x", false).ok());
  EXPECT_FALSE(CheckTransport("http://127.0.0.1.evil.org/x", false).ok());
  EXPECT_FALSE(CheckTransport("http://localhost@h/x", false).ok());
}

}  // namespace
}  // namespace treeline::repository
