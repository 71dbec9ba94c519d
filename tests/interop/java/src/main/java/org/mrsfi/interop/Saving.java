package org.mrsfi.interop;

import com.google.gson.JsonObject;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import org.eclipse.emf.common.util.Diagnostic;
import org.eclipse.emf.common.util.URI;
import org.eclipse.emf.common.util.WrappedException;
import org.eclipse.emf.ecore.EObject;
import org.eclipse.emf.ecore.resource.Resource;
import org.eclipse.emf.ecore.resource.ResourceSet;
import org.eclipse.emf.ecore.resource.URIConverter;
import org.eclipse.emf.ecore.resource.impl.ExtensibleURIConverterImpl;
import org.eclipse.emf.ecore.util.Diagnostician;
import org.eclipse.emf.ecore.util.EcoreUtil;
import org.eclipse.emf.ecore.xmi.impl.XMLContentHandlerImpl;

/** Loads files, says what EMF finds wrong with them, and saves them as Eclipse would. */
final class Saving {

    private Saving() {}

    /**
     * Loads, checks and saves every file of a request by itself.
     *
     * @param request paths under "metamodels" and "models"; folder under "out"
     * @return what was found, file by file, in the order of the request
     */
    static Object resave(JsonObject request) throws IOException {
        Models models = new Models(request);
        Path out = Path.of(request.get("out").getAsString());
        Files.createDirectories(out);
        List<Object> answers = new ArrayList<>();
        for (String path : Models.paths(request, "models")) {
            String name = answers.size() + "-" + Path.of(path).getFileName();
            answers.add(resave(models, path, out.resolve(name)));
        }
        return Map.of("models", answers);
    }

    private static Map<String, Object> resave(Models models, String path, Path saved)
            throws IOException {
        Map<String, Object> answer = new LinkedHashMap<>();
        answer.put("model", path);
        List<String> errors = new ArrayList<>();
        answer.put("errors", errors);
        answer.put("saved", null);
        Resource resource;
        try {
            resource = models.load(path);
        } catch (WrappedException problem) {
            errors.add("load: " + problem.getCause().getMessage());
            return answer;
        }
        errors.addAll(problems(resource));
        answer.put("objects", objects(resource));
        Files.write(saved, bytes(resource));
        answer.put("saved", saved.toString());
        return answer;
    }

    /** Returns everything that EMF has against a resource. */
    static List<String> problems(Resource resource) {
        EcoreUtil.resolveAll(resource.getResourceSet());
        List<String> found = new ArrayList<>();
        for (Resource loaded : resource.getResourceSet().getResources()) {
            loaded.getErrors().forEach(problem -> found.add("error: " + problem));
            loaded.getWarnings().forEach(problem -> found.add("warning: " + problem));
        }
        EcoreUtil.UnresolvedProxyCrossReferencer.find(resource)
                .keySet()
                .forEach(proxy -> found.add("proxy: " + EcoreUtil.getURI(proxy)));
        for (EObject root : resource.getContents()) {
            collect(Diagnostician.INSTANCE.validate(root), found);
        }
        return found;
    }

    private static void collect(Diagnostic diagnostic, List<String> found) {
        if (diagnostic.getSeverity() == Diagnostic.OK) {
            return;
        }
        if (diagnostic.getChildren().isEmpty()) {
            found.add("diagnostic: " + diagnostic.getMessage());
        }
        diagnostic.getChildren().forEach(child -> collect(child, found));
    }

    private static int objects(Resource resource) {
        int count = 0;
        for (var contents = resource.getAllContents(); contents.hasNext(); contents.next()) {
            count++;
        }
        return count;
    }

    /**
     * Returns what Eclipse's editors write: the resource's own defaults, the encoding that it was
     * loaded with, and the line ends of its file. EMF asks for these only where it opens the
     * stream itself, so the converter hands it over, and reads them by a content handler: in
     * Eclipse that of the platform, here that of XML. The address of the resource stays, and with
     * it its relative references.
     */
    static byte[] bytes(Resource resource) throws IOException {
        ByteArrayOutputStream stream = new ByteArrayOutputStream();
        ResourceSet models = resource.getResourceSet();
        URIConverter files = models.getURIConverter();
        URIConverter ours =
                new ExtensibleURIConverterImpl() {
                    @Override
                    public OutputStream createOutputStream(URI address, Map<?, ?> options) {
                        return stream;
                    }
                };
        ours.getContentHandlers().add(new XMLContentHandlerImpl());
        models.setURIConverter(ours);
        try {
            resource.save(
                    Map.of(
                            Resource.OPTION_LINE_DELIMITER,
                            Resource.OPTION_LINE_DELIMITER_UNSPECIFIED));
        } finally {
            models.setURIConverter(files);
        }
        return stream.toByteArray();
    }
}
